#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/config/environment_spec.h"
#include "common/schema/config.pb.h"
#include "tests/unit/support/sizes.h"

/// Environments by their specifications alone, for tests in which nobody plays.
namespace metronome::test {

inline EnvironmentSpec SpecOf(const std::string& name) {
  EnvironmentSpec spec;
  spec.set_name("metaworld/" + name);
  spec.set_short_name(name);
  spec.set_observation_size(kObservationSize);
  spec.set_action_size(kActionSize);
  for (int i = 0; i < kActionSize; ++i) {
    spec.add_action_low(-1);
    spec.add_action_high(1);
  }
  spec.set_max_steps(500);
  spec.set_may_end_early(false);
  spec.set_has_success(true);
  return spec;
}

/// Knows three names, each also with -v3.
inline EnvironmentSpec Describe(const std::string& spelling) {
  std::string name = spelling;
  if (name.ends_with("-v3")) name.resize(name.size() - 3);
  for (const char* known : {"assembly", "box-close", "push"}) {
    if (name == known) return SpecOf(name);
  }
  throw std::invalid_argument("unknown environment \"" + spelling +
                              "\"; Known: assembly, box-close, push");
}

inline void SetTask(RunConfig& config, const std::string& name) {
  config.mutable_environment()->set_task(name);
  *config.mutable_environment()->mutable_spec() = SpecOf(name);
}

}  // namespace metronome::test
