#include "actor/replay/placements.h"

#include <functional>
#include <iostream>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "actor/environment/episode_start.h"
#include "actor/metaworld/placement.h"
#include "actor/metaworld/tasks/benchmarks.h"
#include "actor/metaworld/tasks/task_table.h"
#include "common/schema/config.pb.h"
#include "common/text/near_miss.h"
#include "common/text/number_text.h"

namespace metronome::replay {
namespace {

using metaworld::RandVec;

/// Takes one placement after the other: there may be more than memory holds.
using Sink = std::function<void(const RandVec&)>;

/// @throws std::invalid_argument for a seed that numpy's generator does not take.
std::uint32_t OfficialSeed(const PlacementsOptions& options, const std::string& benchmark) {
  if (options.seed > std::numeric_limits<std::uint32_t>::max())
    throw std::invalid_argument("--seed " + std::to_string(options.seed) + ": " + benchmark +
                                " takes seeds from 0 to 4294967295, as numpy does");
  return static_cast<std::uint32_t>(options.seed);
}

void Mt1(const PlacementsOptions& options, const Sink& sink) {
  const std::uint32_t seed = OfficialSeed(options, "mt1");
  if (options.count > metaworld::kMt1Placements)
    throw std::invalid_argument("--count " + std::to_string(options.count) + ": mt1 has " +
                                std::to_string(metaworld::kMt1Placements) + " placements");
  auto placements = metaworld::Mt1Placements(metaworld::tasks::FindTask(options.task), seed);
  if (options.count > 0) placements.resize(options.count);
  for (const RandVec& placement : placements) sink(placement);
}

void OfTraining(const PlacementsOptions& options, Placements mode, std::uint64_t count,
                const Sink& sink) {
  const metaworld::TaskSpec& task = metaworld::tasks::FindTask(options.task);
  RunConfig config;
  config.mutable_environment()->set_placements(mode);
  config.set_seed(options.seed);
  for (std::uint64_t number = 0; number < count; ++number) {
    environment::EpisodeStart start = environment::TrainingStart(config, number);
    sink(metaworld::StartPlacement(task, mode, start));
  }
}

void Place(const PlacementsOptions& options, const Sink& sink) {
  const auto count_or = [&options](std::uint64_t other) {
    return options.count > 0 ? options.count : other;
  };
  if (options.mode == "random")
    OfTraining(options, PLACEMENTS_RANDOM, count_or(10), sink);
  else if (options.mode == "fixed")
    OfTraining(options, PLACEMENTS_FIXED, count_or(1), sink);
  else if (options.mode == "mt1")
    Mt1(options, sink);
  else
    throw std::invalid_argument(
        text::UnknownName("mode", options.mode, {"random", "fixed", "mt1"}));
}

constexpr int kObjectSize = 3;  // numbers of a placement without a goal

void PrintHeader(std::ostream& out, int size) {
  out << "obj_x,obj_y,obj_z" << (size > kObjectSize ? ",goal_x,goal_y,goal_z" : "") << '\n';
}

void PrintNumbers(std::ostream& out, const RandVec& placement, int size) {
  for (int i = 0; i < size; ++i) out << (i > 0 ? "," : "") << text::FormatNumber(placement[i]);
}

/// Throws where the last rows went nowhere.
void RequireWritten(const std::ostream& out) {
  if (!out) throw std::runtime_error("cannot write the output");
}

/// Prints rows, with the header before the first.
class Table {
 public:
  /// @param size  numbers a placement.
  Table(std::ostream* out, int size) : out_(*out), size_(size) {}

  void Add(const RandVec& placement) {
    if (!std::exchange(begun_, true)) PrintHeader(out_, size_);
    PrintNumbers(out_, placement, size_);
    out_ << '\n';
    RequireWritten(out_);
  }

 private:
  std::ostream& out_;
  const int size_;
  bool begun_ = false;  // bad options leave the output empty
};

void OfTask(const PlacementsOptions& options, std::ostream& out) {
  Table table(&out, metaworld::tasks::FindTask(options.task).placement_size);
  Place(options, [&table](const RandVec& placement) { table.Add(placement); });
}

/// @param split  what each row begins with.
void PrintTasks(const std::vector<metaworld::tasks::TaskPlacements>& tasks,
                const std::string& split, std::ostream& out) {
  for (const auto& [task, placements] : tasks) {
    const std::string rest(placements.front().size() - task->placement_size, ',');
    for (std::size_t i = 0; i < placements.size(); ++i) {
      out << split << task->name << ',' << i << ',';
      PrintNumbers(out, placements[i], task->placement_size);
      out << rest << '\n';
    }
    RequireWritten(out);
  }
}

void OfBenchmark(const PlacementsOptions& options, std::ostream& out) {
  const metaworld::tasks::Benchmark& benchmark = metaworld::tasks::FindBenchmark(options.benchmark);
  const std::uint32_t seed = OfficialSeed(options, benchmark.name);
  const auto train = metaworld::tasks::BenchmarkPlacements(benchmark.train, seed);
  const auto test = metaworld::tasks::BenchmarkPlacements(benchmark.test, seed);
  const bool has_both = !test.empty();
  out << (has_both ? "split," : "") << "task,index,";
  PrintHeader(out, 2 * kObjectSize);
  PrintTasks(train, has_both ? "train," : "", out);
  PrintTasks(test, "test,", out);
}

}  // namespace

int RunPlacements(const PlacementsOptions& options, std::ostream& out) {
  try {
    if (options.benchmark.empty())
      OfTask(options, out);
    else
      OfBenchmark(options, out);
    out << std::flush;
    RequireWritten(out);
    return 0;
  } catch (const std::invalid_argument& error) {
    std::cerr << "placements: " << error.what() << '\n';
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "placements: " << error.what() << '\n';
    return 1;
  }
}

}  // namespace metronome::replay
