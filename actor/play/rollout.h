#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "actor/metaworld/environment.h"
#include "common/messages/episode.h"
#include "common/messages/messages.h"
#include "common/schema/config.pb.h"

namespace metronome {

/// The placement that episode `number` of a training run starts from: a function of the
/// environment's configuration, the run seed and the number alone.
metaworld::RandVec TrainingPlacement(const RunConfig& config, std::uint64_t number);

/// Plays episode `number` under `snapshot`: a pure function of its arguments (`environment` is only
/// a machine to run it on; nothing of its past enters).
/// @param cancel  polled once a step. @return std::nullopt if it became true.
std::optional<Episode> PlayEpisode(const RunConfig& config, const PolicySnapshot& snapshot,
                                   std::uint64_t number, metaworld::Environment& environment,
                                   const std::atomic<bool>& cancel);

}  // namespace metronome
