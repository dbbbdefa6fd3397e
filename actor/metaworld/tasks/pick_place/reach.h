#pragma once

#include "actor/metaworld/tasks/pick_place/free_object.h"

namespace metronome::metaworld::tasks::pick_place {

/// The hand itself is to be at the goal; a puck lies on the table, for nothing.
class Reach : public Block {
 public:
  Reach(const TaskSpec& task, const EnvironmentOptions& options) : Block(task, options, "goal") {}

 protected:
  Outcome Evaluate(const Observation& observation, const Action& action) override;
};

}  // namespace metronome::metaworld::tasks::pick_place
