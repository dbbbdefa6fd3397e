/// Gradient steps of SAC alone, on synthetic episodes. Prints how fast they are: one JSON line.
/// With
/// --out it also writes all that another program needs to make the same steps (numpy's arrays, and
/// a header in JSON): the replay, which samples and which noise each step has, and the parameters
/// before and after. tests/bench/peers/torch_sac_steps.py reads that.
#include <google/protobuf/util/json_util.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/config/config.h"
#include "common/kernels/isa_option.h"
#include "common/numbers/random.h"
#include "learner/network/running_statistics.h"
#include "learner/network/worker_team.h"
#include "learner/sac/draw_batch.h"
#include "learner/sac/gradient_step.h"
#include "learner/sac/replay.h"
#include "learner/sac/sac_networks.h"
#include "learner/sac/sac_state.h"
#include "learner/sac/transition.h"
#include "tests/unit/support/environments.h"
#include "tests/unit/support/synthetic_run.h"

namespace metronome::sac {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> settings;
  int tasks = 1;
  int episodes = 24;
  int steps = 20;
  int threads = 1;
  std::string out;
};

RunConfig ConfigOf(const Options& options) {
  config::ConfigDraft draft;
  draft.ChooseAlgorithm("sac", "sac_steps");
  draft.Set("environment.task", "push", "sac_steps");
  for (const std::string& setting : options.settings) draft.SetFromArgument(setting);
  return draft.Finish([&](const std::string& name) {
    EnvironmentSpec spec = test::SpecOf(name);
    for (int i = 0; options.tasks > 1 && i < options.tasks; ++i) {
      spec.add_tasks("task-" + std::to_string(i));
    }
    return spec;
  });
}

void Spread(double by, numbers::RandomStream& random, std::vector<float>& parameters) {
  for (float& parameter : parameters) parameter += float(by * random.Normal());
}

/// A learner's in the middle of its run: heads differ, critics have values, and targets lag.
OptimiserState StateOf(const RunConfig& config) {
  OptimiserState state = InitialSacState(config).optimiser;
  numbers::RandomStream random(numbers::RandomPurpose::kEvaluate, 1, 0, 0);
  Spread(0.02, random, state.actor);
  Spread(0.02, random, state.critics);
  state.targets = state.critics;
  Spread(0.005, random, state.targets);
  Spread(0.3, random, state.log_temperature);
  return state;
}

/// A run's replay, and the policy with the statistics of its observations.
struct Played {
  Played(const RunConfig& config, int episodes) : replay(config) {
    SacState state = InitialSacState(config);
    const PolicySnapshot player = SnapshotOf(state, config);
    for (int i = 0; i < episodes; ++i) {
      Episode episode = testing::SyntheticEpisode(config, player, std::uint64_t(i));
      network::Merge(state.observation[std::size_t(i) % state.observation.size()],
                     episode.observation.data(), std::size_t(episode.length()),
                     test::kObservationSize, test::kObservationSize);
      replay.Add(std::move(episode));
    }
    snapshot = SnapshotOf(state, config);
  }

  Replay replay;
  PolicySnapshot snapshot;
};

/// A row-major array in numpy's format 1.0.
template <typename Number>
void WriteArray(const fs::path& path, const std::vector<std::size_t>& shape,
                const std::vector<Number>& numbers) {
  static_assert(sizeof(Number) == 4);
  std::string header = std::string("{'descr': '") +
                       (std::is_floating_point_v<Number> ? "<f4" : "<i4") +
                       "', 'fortran_order': False, 'shape': (";
  std::size_t size = 1;
  for (const std::size_t n : shape) {
    header += std::to_string(n) + ",";
    size *= n;
  }
  header += ")}";
  header.append(63 - (10 + header.size()) % 64, ' ');
  header += '\n';
  if (size != numbers.size()) throw std::logic_error(path.string() + ": not the shape's numbers");
  std::ofstream file(path, std::ios::binary);
  file << std::string("\x93NUMPY\x01\x00", 8) << char(header.size() & 0xff)
       << char(header.size() >> 8) << header;
  file.write(reinterpret_cast<const char*>(numbers.data()),
             std::streamsize(numbers.size() * sizeof(Number)));
  if (!file.flush()) throw std::runtime_error("cannot write " + path.string());
}

nlohmann::json JsonOf(const policy::LayerSlice& slice) {
  return {{"weight", slice.weight}, {"bias", slice.bias}, {"shape", {slice.outputs, slice.inputs}}};
}

nlohmann::json JsonOf(const policy::MlpLayout& layout) {
  nlohmann::json json = {
      {"size", layout.size}, {"heads", layout.heads}, {"head", JsonOf(layout.head)}};
  for (const policy::LayerSlice& slice : layout.hidden) json["hidden"].push_back(JsonOf(slice));
  return json;
}

nlohmann::json JsonOf(const RunConfig& config) {
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  std::string text;
  if (!google::protobuf::util::MessageToJsonString(config, &text, options).ok()) {
    throw std::logic_error("the configuration is no JSON");
  }
  return nlohmann::json::parse(text);
}

/// The folder for another program.
class Writer {
 public:
  Writer(const RunConfig& config, const Played& played, fs::path folder)
      : config_(config), folder_(std::move(folder)) {
    fs::create_directories(folder_);
    WriteHeader();
    WriteReplay(played.replay);
    WriteArray(folder_ / "observation_mean.npy", {tasks(), test::kObservationSize},
               played.snapshot.observation_mean);
    WriteArray(folder_ / "observation_inv_std.npy", {tasks(), test::kObservationSize},
               played.snapshot.observation_inv_std);
  }

  /// @param when  "before" or "after".
  void Parameters(const OptimiserState& state, const std::string& when) const {
    const auto write = [&](const std::string& name, const std::vector<float>& parameters) {
      WriteArray(folder_ / (name + "_" + when + ".npy"), {parameters.size()}, parameters);
    };
    write("actor", state.actor);
    write("critics", state.critics);
    write("targets", state.targets);
    write("log_temperature", state.log_temperature);
  }

  void Take(const std::vector<Transition>& batch, std::uint64_t gradient_step) {
    for (std::size_t row = 0; row < batch.size(); ++row) {
      samples_.push_back(std::int32_t(batch[row].step.of->episode.number));
      samples_.push_back(batch[row].step.t);
      for (const std::uint64_t which : {0, 1}) TakeNoise(gradient_step, 2 * row + which);
    }
  }

  void Samples() const {
    const auto batch = std::size_t(config_.sac().batch());
    const std::size_t steps = samples_.size() / 2 / batch;
    WriteArray(folder_ / "samples.npy", {steps, batch, 2}, samples_);
    WriteArray(folder_ / "noise.npy", {steps, batch, 2, test::kActionSize}, noise_);
  }

 private:
  [[nodiscard]] std::size_t tasks() const { return std::size_t(policy::ShapeOf(config_).tasks); }

  void WriteHeader() const {
    const SacNetworks networks(config_);
    const nlohmann::json header = {{"config", JsonOf(config_)},
                                   {"heads", networks.shape.heads},
                                   {"actor", JsonOf(networks.actor)},
                                   {"critic", JsonOf(networks.critic)}};
    std::ofstream(folder_ / "header.json") << header.dump(1) << '\n';
  }

  void WriteReplay(const Replay& replay) const {
    std::vector<float> observation;
    std::vector<float> action;
    std::vector<float> reward;
    std::vector<std::int32_t> head;  // of each observation, the final one's too
    for (std::size_t i = 0; i < replay.episodes(); ++i) {
      const Episode& of = replay.episode(i).episode;
      observation.insert(observation.end(), of.observation.begin(), of.observation.end());
      action.insert(action.end(), of.action.begin(), of.action.end());
      reward.insert(reward.end(), of.reward.begin(), of.reward.end());
      head.insert(head.end(), of.head.begin(), of.head.end());
      head.push_back(replay.episode(i).final_head);
    }
    const std::size_t episodes = replay.episodes();
    const std::size_t length = reward.size() / episodes;
    WriteArray(folder_ / "observation.npy", {episodes, length + 1, test::kObservationSize},
               observation);
    WriteArray(folder_ / "action.npy", {episodes, length, test::kActionSize}, action);
    WriteArray(folder_ / "reward.npy", {episodes, length}, reward);
    WriteArray(folder_ / "head.npy", {episodes, length + 1}, head);
  }

  // As GradientStep draws it.
  void TakeNoise(std::uint64_t gradient_step, std::uint64_t draw) {
    numbers::RandomStream random(numbers::RandomPurpose::kUpdateNoise, config_.seed(),
                                 gradient_step, draw);
    for (int i = 0; i < test::kActionSize; ++i) noise_.push_back(float(random.Normal()));
  }

  RunConfig config_;
  fs::path folder_;
  std::vector<std::int32_t> samples_;  // [steps, batch, 2]: number of the episode, t
  std::vector<float> noise_;           // [steps, batch, 2, action]: in the next state, in the state
};

double Median(std::vector<double> values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void Run(const Options& options) {
  const RunConfig config = ConfigOf(options);
  const Played played(config, options.episodes);
  OptimiserState state = StateOf(config);
  std::optional<Writer> writer;
  if (!options.out.empty()) writer.emplace(config, played, options.out);
  if (writer) writer->Parameters(state, "before");
  network::WorkerTeam team(options.threads);
  GradientStep step(config, team);
  step.Begin(state);
  std::vector<double> seconds;
  for (int i = 0; i < options.steps; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    const auto batch = DrawBatch(played.replay, config, state.gradient_steps);
    step.Run(batch, played.snapshot, state);
    seconds.push_back(
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    if (writer) writer->Take(batch, state.gradient_steps - 1);
  }
  if (writer) {
    writer->Parameters(state, "after");
    writer->Samples();
  }
  const double rate = config.sac().batch() / Median(seconds);
  std::printf("{\"batch\": %d, \"threads\": %d, \"samples_per_second\": %.0f}\n",
              config.sac().batch(), options.threads, rate);
}

int Main(int argc, char** argv) {
  Options options;
  CLI::App app("Gradient steps of SAC alone; one JSON line");
  app.add_option("--set", options.settings, "NAME=VALUE, as the learner's");
  app.add_option("--tasks", options.tasks, "of the run")->capture_default_str();
  app.add_option("--episodes", options.episodes, "of the replay")->capture_default_str();
  app.add_option("--steps", options.steps, "gradient steps")->capture_default_str();
  app.add_option("--threads", options.threads)->capture_default_str();
  app.add_option("--out", options.out, "folder for all that another program needs");
  kernels::AddIsaOption(app);
  CLI11_PARSE(app, argc, argv);
  Run(options);
  return 0;
}

}  // namespace
}  // namespace metronome::sac

int main(int argc, char** argv) {
  try {
    return metronome::sac::Main(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "sac_steps: %s\n", error.what());
    return 1;
  }
}
