#pragma once

#include "actor/metaworld/sawyer.h"

/// What the two tasks with a wrench's ring and a peg share.
namespace metronome::metaworld::tasks::nuts {

struct Placed {
  double reward = 0;  // in [0, 1]
  bool success = false;
};

class Nut : public SawyerEnvironment {
 protected:
  Nut(const TaskSpec& task, const EnvironmentOptions& options, const CagingShape& caging);

  [[nodiscard]] int Peg() const { return peg_; }  // body
  [[nodiscard]] Eigen::Vector3d Ring() const { return SitePosition(ring_); }

 private:
  [[nodiscard]] ObjectPose Object() const final;
  Outcome Evaluate(const Observation& observation, const Action& action) final;
  /// @param wrench  as observed: its handle.
  [[nodiscard]] virtual Placed RewardPlace(const Eigen::Vector3d& wrench) const = 0;

  const CagingShape caging_;
  const int nut_, peg_, handle_, ring_;
};

}  // namespace metronome::metaworld::tasks::nuts
