#pragma once

#include "learner/collect/assignments/assignment_rules.h"

namespace metronome::test {

inline collect::assignments::AssignmentRules Rules(std::uint64_t episodes, std::uint64_t updates,
                                                   std::uint64_t overlap = 0) {
  collect::assignments::AssignmentRules rules;
  rules.episodes_per_update = episodes;
  rules.updates_total = updates;
  rules.overlap = overlap;
  return rules;
}

}  // namespace metronome::test
