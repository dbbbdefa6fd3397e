#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "actor/environment/episode_start.h"
#include "actor/metaworld/step_result.h"
#include "actor/metaworld/task_spec.h"
#include "common/numbers/random.h"
#include "common/schema/config.pb.h"

/// Where an episode starts: object and goal. Pure functions.
namespace metronome::metaworld {

inline constexpr int kMt1Placements = 50;

/// One placement, uniform over the task's box; too short distances are drawn again (spec
/// section 4), from the same stream.
RandVec DrawPlacement(const TaskSpec& task, numbers::RandomStream& stream);

/// The placements that the official package draws for its benchmarks, number for number: with
/// numpy's legacy generator, two draws (each with rejection) a reset, of which the second is kept.
class OfficialPlacements {
 public:
  /// numpy.random.seed(seed).
  explicit OfficialPlacements(std::uint32_t seed) : twister_(seed) {}

  /// The 50 of the benchmark's next task; the stream goes on from task to task.
  std::vector<RandVec> Next(const TaskSpec& task);

 private:
  std::mt19937 twister_;
};

/// The 50 placements of the official MT1 benchmark for `seed`.
std::vector<RandVec> Mt1Placements(const TaskSpec& task, std::uint32_t seed);

/// Of the official placements that an episode starts at: of a training episode drawn, of
/// evaluations one after the other.
const RandVec& PickOfficial(const std::vector<RandVec>& official, environment::EpisodeStart& start);

/// The placement that an episode starts at. With PLACEMENTS_MT1 one of the official 50 of the key's
/// seed; not with PLACEMENTS_BENCHMARK, which is of several tasks.
RandVec StartPlacement(const TaskSpec& task, Placements placements,
                       environment::EpisodeStart& start);

}  // namespace metronome::metaworld
