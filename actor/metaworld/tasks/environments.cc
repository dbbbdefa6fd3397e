#include "actor/metaworld/tasks/environments.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "actor/environment/mujoco_view.h"
#include "actor/metaworld/assets.h"
#include "actor/metaworld/placement.h"
#include "actor/metaworld/sawyer.h"
#include "actor/metaworld/tasks/benchmarks.h"
#include "actor/metaworld/tasks/task_table.h"

namespace metronome::metaworld::tasks {
namespace {

constexpr double kControlStep = 0.0125;  // seconds: five physics steps

/// A scene behind the contract that all environments share.
class MetaworldEnvironment final : public environment::Environment, public environment::MujocoView {
 public:
  MetaworldEnvironment(const TaskSpec& task, const EnvironmentConfig& config)
      : task_(task),
        placements_(config.placements()),
        run_tasks_(config.spec().tasks().begin(), config.spec().tasks().end()),
        scene_(task.make(task, {.goal_visible = config.goal_visible(), .assets = ""})) {}

  void Reset(environment::EpisodeStart& start, std::span<float> observation) override {
    const RandVec placement = placements_ == PLACEMENTS_BENCHMARK
                                  ? PickOfficial(OfBenchmark(start.key.seed), start)
                                  : StartPlacement(task_, placements_, start);
    Show(scene_->Reset(placement), observation);
  }

  environment::StepOutcome Step(std::span<const float> action,
                                std::span<float> observation) override {
    Action given{};
    std::copy_n(action.begin(), given.size(), given.begin());
    const StepResult result = scene_->Step(given);
    Show(result.observation, observation);
    return {.reward = result.reward,
            .success = result.info.success,
            .terminated = false,
            .truncated = result.truncated};
  }

  [[nodiscard]] const environment::MujocoView* mujoco() const override { return this; }
  [[nodiscard]] const mjModel& model() const override { return scene_->model(); }
  [[nodiscard]] const mjData& data() const override { return scene_->data(); }
  [[nodiscard]] environment::Landmarks landmarks() const override {
    return {.hand = {shown_[0], shown_[1], shown_[2]},
            .object = {shown_[4], shown_[5], shown_[6]},
            .gripper = shown_[3]};
  }
  [[nodiscard]] environment::CameraView view() const override { return task_.view; }
  [[nodiscard]] double steps_per_second() const override { return 1 / kControlStep; }

 private:
  /// This task's in the benchmark that the run's tasks are, kept for the next episode.
  const std::vector<RandVec>& OfBenchmark(std::uint64_t seed) {
    if (seed == benchmark_seed_) return benchmark_;
    for (TaskPlacements& of_task :
         BenchmarkPlacements(run_tasks_, static_cast<std::uint32_t>(seed))) {
      if (of_task.task == &task_) benchmark_ = std::move(of_task.placements);
    }
    benchmark_seed_ = seed;
    return benchmark_;
  }

  void Show(const Observation& full, std::span<float> observation) {
    shown_ = full;
    std::transform(full.begin(), full.end(), observation.begin(),
                   [](double number) { return static_cast<float>(number); });
  }

  const TaskSpec& task_;
  const Placements placements_;
  const std::vector<std::string> run_tasks_;  // of several
  std::optional<std::uint64_t> benchmark_seed_;
  std::vector<RandVec> benchmark_;  // of that seed
  const std::unique_ptr<SawyerEnvironment> scene_;
  Observation shown_{};
};

EnvironmentSpec SpecOf(const TaskSpec& task) {
  EnvironmentSpec spec;
  spec.set_name("metaworld/" + task.name);
  spec.set_short_name(task.name);
  spec.set_observation_size(kObservationSize);
  spec.set_action_size(kActionSize);
  for (int i = 0; i < kActionSize; ++i) {
    spec.add_action_low(-1);
    spec.add_action_high(1);
  }
  spec.set_max_steps(kMaxSteps);
  spec.set_may_end_early(false);
  spec.set_has_success(true);
  return spec;
}

std::optional<std::int32_t> DifferentStarts(const EnvironmentConfig& config) {
  if (config.placements() == PLACEMENTS_MT1 || config.placements() == PLACEMENTS_BENCHMARK)
    return kMt1Placements;
  return std::nullopt;
}

}  // namespace

std::vector<environment::EnvironmentEntry> Environments() {
  std::vector<environment::EnvironmentEntry> entries;
  for (const TaskSpec& task : AllTasks()) {
    entries.push_back({.spec = SpecOf(task),
                       .aliases = {task.name + "-v2", task.name + "-v3"},
                       .make =
                           [&task](const EnvironmentConfig& config) {
                             return std::make_unique<MetaworldEnvironment>(task, config);
                           },
                       .different_starts = DifferentStarts});
  }
  return entries;
}

std::vector<environment::TaskGroup> Groups() {
  std::vector<environment::TaskGroup> groups;
  for (const Benchmark& benchmark : AllBenchmarks()) {
    const bool ml = !benchmark.test.empty();
    groups.push_back({benchmark.name + (ml ? "-train" : ""), benchmark.train, true});
    if (ml) groups.push_back({benchmark.name + "-test", benchmark.test, true});
  }
  return groups;
}

void RequireScenes() {
  const std::string assets = DefaultAssetsPath();
  if (std::filesystem::is_directory(assets)) return;
  throw std::runtime_error("the Meta-World scene files are not at " + assets +
                           ": run deploy/setup");
}

}  // namespace metronome::metaworld::tasks
