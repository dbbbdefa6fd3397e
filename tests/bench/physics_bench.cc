/// The actor's loop against the bare engine, over the same episodes: the bare loop replays the
/// actions that the actor's policy chose, from the same reset state, so both do the same physics.
/// Items are control steps (five mj_step and one mj_forward each).
#include <benchmark/benchmark.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "actor/environment/mujoco_view.h"
#include "actor/metaworld/engine/engine.h"
#include "actor/metaworld/engine/looks.h"
#include "actor/metaworld/step_result.h"
#include "actor/metaworld/tasks/environments.h"
#include "actor/metaworld/tasks/task_table.h"
#include "actor/play/rollout.h"
#include "common/config/config.h"
#include "learner/ppo/trainer.h"

namespace metronome {
namespace {

constexpr int kEpisodes = 4;  // different ones, played round and round

const environment::EnvironmentRegistry& Registry() {
  static const environment::EnvironmentRegistry registry(metaworld::tasks::Environments());
  return registry;
}

RunConfig ConfigOf(const std::string& task) {
  RunConfig config;
  config.mutable_environment()->set_task(task);
  *config.mutable_environment()->mutable_spec() = Registry().Describe(task);
  return config::Resolve(config);
}

std::unique_ptr<environment::Environment> MakeEnvironmentOf(const std::string& task) {
  return Registry().Make(ConfigOf(task).environment());
}

/// The untrained policy's episodes 0..kEpisodes-1 of a task: played once a process, then shared.
struct Episodes {
  explicit Episodes(const std::string& task)
      : config(ConfigOf(task)),
        snapshot(ppo::SnapshotOf(ppo::Trainer::InitialState(config), config)) {
    const auto environment = MakeEnvironmentOf(task);
    const std::atomic<bool> cancel{false};
    for (int i = 0; i < kEpisodes; ++i) {
      episodes.push_back(
          *play::PlayEpisode(config, snapshot, std::uint64_t(i), *environment, cancel));
    }
  }

  static const Episodes& Of(const std::string& task) {
    static std::mutex mutex;
    static std::map<std::string, Episodes> all;
    const std::lock_guard lock(mutex);
    return all.try_emplace(task, task).first->second;
  }

  RunConfig config;
  PolicySnapshot snapshot;
  std::vector<Episode> episodes;
};

/// The scene's whole model, as the official environment has it (actors keep a slim one), in an
/// episode's start.
metaworld::engine::DataPtr StartOf(const mjModel& model, const mjData& start) {
  metaworld::engine::DataPtr data(mj_makeData(&model));
  data->time = start.time;
  std::copy_n(start.qpos, model.nq, data->qpos);
  std::copy_n(start.qvel, model.nv, data->qvel);
  std::copy_n(start.qacc_warmstart, model.nv, data->qacc_warmstart);
  std::copy_n(start.ctrl, model.nu, data->ctrl);
  std::copy_n(start.mocap_pos, 3 * model.nmocap, data->mocap_pos);
  std::copy_n(start.mocap_quat, 4 * model.nmocap, data->mocap_quat);
  return data;
}

/// A bare mjData at an episode's start, and the controls of its steps.
class BareLoop {
 public:
  explicit BareLoop(const std::string& task)
      : environment_(MakeEnvironmentOf(task)), hand_(metaworld::tasks::FindTask(task).hand) {
    const Episodes& played = Episodes::Of(task);
    const environment::MujocoView& scene = *environment_->mujoco();
    std::vector<float> observation(
        std::size_t(played.config.environment().spec().observation_size()));
    for (int i = 0; i < kEpisodes; ++i) {
      environment::EpisodeStart start = environment::TrainingStart(played.config, std::uint64_t(i));
      environment_->Reset(start, observation);
      models_.push_back(metaworld::engine::CopyToDraw(scene.model()));
      starts_.push_back(StartOf(*models_.back(), scene.data()));
    }
  }

  void Start(int episode) {
    model_ = models_[std::size_t(episode)].get();
    data_ = starts_[std::size_t(episode)].get();
    saved_.reset(mj_copyData(saved_.release(), model_, data_));
  }

  /// The controls of one action, then the engine alone.
  void Step(const float* action) {
    for (int i = 0; i < 3; ++i) {
      const double moved = data_->mocap_pos[i] + std::clamp(action[i], -1.0F, 1.0F) * 0.01F;
      data_->mocap_pos[i] = std::clamp(moved, hand_.low[i], hand_.high[i]);
    }
    data_->ctrl[0] = action[3];
    data_->ctrl[1] = -action[3];
    for (int k = 0; k < 5; ++k) mj_step(model_, data_);
    mj_forward(model_, data_);
  }

  /// Puts the episode's start back.
  void Finish() { mj_copyData(data_, model_, saved_.get()); }

 private:
  std::unique_ptr<environment::Environment> environment_;
  const metaworld::HandSettings& hand_;
  std::vector<metaworld::engine::ModelPtr> models_;
  std::vector<metaworld::engine::DataPtr> starts_;
  metaworld::engine::DataPtr saved_;
  mjModel* model_ = nullptr;
  mjData* data_ = nullptr;
};

void Bare(benchmark::State& state, const std::string& task) {
  const Episodes& played = Episodes::Of(task);
  BareLoop loop(task);
  int next = 0;
  for (auto _ : state) {
    state.PauseTiming();
    const Episode& episode = played.episodes[std::size_t(next)];
    loop.Start(next);
    state.ResumeTiming();
    for (std::int32_t t = 0; t < episode.length(); ++t) {
      loop.Step(episode.action.data() + std::size_t(t) * metaworld::kActionSize);
    }
    state.PauseTiming();
    loop.Finish();
    next = (next + 1) % kEpisodes;
    state.ResumeTiming();
  }
  state.SetItemsProcessed(state.iterations() * played.config.environment().horizon());
}

void Actor(benchmark::State& state, const std::string& task) {
  const Episodes& played = Episodes::Of(task);
  const auto environment = MakeEnvironmentOf(task);
  const std::atomic<bool> cancel{false};
  std::uint64_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        play::PlayEpisode(played.config, played.snapshot, next, *environment, cancel));
    next = (next + 1) % kEpisodes;
  }
  state.SetItemsProcessed(state.iterations() * played.config.environment().horizon());
}

void Register() {
  for (const environment::EnvironmentEntry& entry : Registry().entries()) {
    const std::string& task = entry.spec.short_name();
    for (const int threads : {1, 2}) {
      benchmark::RegisterBenchmark(("bare/" + task).c_str(), Bare, task)
          ->Threads(threads)
          ->UseRealTime()
          ->Unit(benchmark::kMillisecond);
      benchmark::RegisterBenchmark(("actor/" + task).c_str(), Actor, task)
          ->Threads(threads)
          ->UseRealTime()
          ->Unit(benchmark::kMillisecond);
    }
  }
}

}  // namespace
}  // namespace metronome

int main(int argc, char** argv) {
  metronome::Register();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
