#pragma once

#include <cstdint>
#include <vector>

namespace metronome {

/// Ceilings of what an environment may be like, the wire's own (idl/metronome.idl); a run's real
/// sizes are in its EnvironmentSpec (common/schema/config.proto).
inline constexpr int kMaxObservationSize = 1024;
inline constexpr int kMaxActionSize = 64;
inline constexpr int kMaxSteps = 10000;
inline constexpr int kMaxTasks = 64;     // of a run
inline constexpr int kMaxHeads = 65535;  // of a policy in all: Episode::head has 16 bits

/// Bits of Episode::flags.
enum StepFlag : std::uint8_t {
  kStepSuccess = 1,     // the task's success criterion holds after this step
  kStepTerminated = 2,  // the state after this step is absorbing (Meta-World never sets it)
  kStepTruncated = 4,   // the time limit cut the episode here: set exactly at the last step
};

/// One whole episode of T steps: what actors publish and an update consumes. Arrays are row-major;
/// observations have O numbers, actions A, as the run's EnvironmentSpec says.
/// float32 throughout: the policy saw exactly these observations, so the learner can recompute
/// every action and log-probability bit for bit.
struct Episode {
  std::uint64_t number = 0;           // position in the run, from 0
  std::uint64_t weights_version = 0;  // the policy snapshot that acted
  std::vector<float> observation;     // [T + 1, O]; row t precedes step t, row T is the final one
  std::vector<float> action;          // [T, A], as sampled: before the environment clips
  std::vector<float> log_prob;        // [T], nats, of the unclipped action
  std::vector<float> reward;          // [T], the environment's own scale
  std::vector<std::uint16_t> head;    // [T], by the run's schedule (head_schedule.h)
  std::vector<std::uint8_t> flags;    // [T], StepFlag bits

  [[nodiscard]] std::int32_t length() const { return static_cast<std::int32_t>(reward.size()); }
  bool operator==(const Episode&) const = default;
};

}  // namespace metronome
