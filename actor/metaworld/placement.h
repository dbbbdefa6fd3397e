#pragma once

#include <cstdint>
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

/// The 50 placements of the official MT1 benchmark for `seed`, number for number. The official
/// package draws them with numpy's legacy generator: two draws (each with rejection) a reset, of
/// which the second is kept.
std::vector<RandVec> Mt1Placements(const TaskSpec& task, std::uint32_t seed);

/// The placement that an episode starts at. With PLACEMENTS_MT1 one of the official 50 of the key's
/// seed: of a training episode drawn, of evaluations one after the other.
RandVec StartPlacement(const TaskSpec& task, Placements placements,
                       environment::EpisodeStart& start);

}  // namespace metronome::metaworld
