#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "actor/environment/environment.h"
#include "common/messages/episode.h"
#include "common/messages/messages.h"
#include "common/schema/config.pb.h"

namespace metronome::play {

/// Plays episode `number` under `snapshot`: a pure function of its arguments (`environment` is only
/// a machine to run it on; nothing of its past enters).
/// It is whole when the environment ends it, else after the horizon's steps.
/// @throws std::logic_error if the environment ends it early though its specification says that it
///         does not.
/// @param cancel  polled once a step. @return std::nullopt if it became true.
std::optional<Episode> PlayEpisode(const RunConfig& config, const PolicySnapshot& snapshot,
                                   std::uint64_t number, environment::Environment& environment,
                                   const std::atomic<bool>& cancel);

}  // namespace metronome::play
