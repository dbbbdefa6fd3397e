#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/messages/episode.h"
#include "common/messages/messages.h"
#include "common/schema/config.pb.h"

namespace metronome::client {

/// A machine that plays episodes of one run, one at a time. Not thread-safe; may be handed from
/// thread to thread.
class EpisodePlayer {
 public:
  virtual ~EpisodePlayer() = default;
  /// @param snapshot  of the run's network shape.
  /// @param cancel    polled once a step. @return std::nullopt if it became true.
  virtual std::optional<Episode> Play(const PolicySnapshot& snapshot, std::uint64_t number,
                                      const std::atomic<bool>& cancel) = 0;
};

/// An actor's preparation for a run, made when it joins.
struct RunSetup {
  std::string canonical_digest;                         // see ActorStatus
  std::vector<std::unique_ptr<EpisodePlayer>> players;  // one an env
};

/// Makes `envs` players for a run (seconds: scenes may be loaded). @throws what making them
/// throws.
using SetUpRun = std::function<RunSetup(const RunConfig& config, int envs)>;

}  // namespace metronome::client
