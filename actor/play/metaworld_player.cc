#include "actor/client/episode_player.h"
#include "actor/metaworld/assets.h"
#include "actor/metaworld/environment.h"
#include "actor/metaworld/tasks/task_table.h"
#include "actor/play/canonical_episode.h"
#include "actor/play/rollout.h"
#include "common/process/cpu_times.h"

namespace metronome {
namespace {

class MetaworldPlayer final : public EpisodePlayer {
 public:
  explicit MetaworldPlayer(const RunConfig& config)
      : config_(config),
        environment_(metaworld::MakeEnvironment(
            config.environment().task(), {.goal_visible = config.environment().goal_visible(),
                                          .assets = metaworld::DefaultAssetsPath()})) {}

  std::optional<Episode> Play(const PolicySnapshot& snapshot, std::uint64_t number,
                              const std::atomic<bool>& cancel) override {
    return PlayEpisode(config_, snapshot, number, *environment_, cancel);
  }

 private:
  const RunConfig config_;
  const std::unique_ptr<metaworld::Environment> environment_;
};

}  // namespace

RunSetup SetUpMetaworldRun(const RunConfig& config, int slots) {
  const CpuTimer timer(CpuUse::kSetUp);
  RunSetup setup;
  for (int slot = 0; slot < slots; ++slot) {
    setup.players.push_back(std::make_unique<MetaworldPlayer>(config));
  }
  setup.canonical_digest =
      CanonicalDigest(config.environment().task(), metaworld::DefaultAssetsPath());
  return setup;
}

}  // namespace metronome
