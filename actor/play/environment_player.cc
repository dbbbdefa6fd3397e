#include "actor/play/environment_player.h"

#include "actor/play/canonical_episode.h"
#include "actor/play/rollout.h"
#include "common/policy/task_of.h"
#include "common/process/cpu_times.h"

namespace metronome::play {
namespace {

class EnvironmentPlayer final : public client::EpisodePlayer {
 public:
  EnvironmentPlayer(const environment::EnvironmentRegistry& registry, const RunConfig& config)
      : registry_(registry), config_(config), environments_(policy::TaskCount(config)) {
    EnvironmentOf(0);  // what this machine lacks shows when the run starts
  }

  std::optional<Episode> Play(const PolicySnapshot& snapshot, std::uint64_t number,
                              const std::atomic<bool>& cancel) override {
    return PlayEpisode(config_, snapshot, number, EnvironmentOf(policy::TaskOf(config_, number)),
                       cancel);
  }

 private:
  /// Made when it is first played.
  environment::Environment& EnvironmentOf(std::size_t task) {
    auto& environment = environments_.at(task);
    if (!environment) environment = registry_.Make(config_.environment(), task);
    return *environment;
  }

  const environment::EnvironmentRegistry& registry_;
  const RunConfig config_;
  std::vector<std::unique_ptr<environment::Environment>> environments_;  // [tasks]
};

}  // namespace

client::SetUpRun SetUpWith(const environment::EnvironmentRegistry& registry) {
  return [&registry](const RunConfig& config, int envs) {
    const process::CpuTimer timer(process::CpuUse::kSetUp);
    client::RunSetup setup;
    for (int env = 0; env < envs; ++env) {
      setup.players.push_back(std::make_unique<EnvironmentPlayer>(registry, config));
    }
    setup.canonical_digest = CanonicalDigest(registry, config.environment().task());
    return setup;
  };
}

}  // namespace metronome::play
