#include "actor/replay/placements.h"

#include <functional>
#include <iostream>
#include <limits>
#include <stdexcept>
#include <utility>

#include "actor/environment/episode_start.h"
#include "actor/metaworld/placement.h"
#include "actor/metaworld/tasks/task_table.h"
#include "common/schema/config.pb.h"
#include "common/text/near_miss.h"
#include "common/text/number_text.h"

namespace metronome::replay {
namespace {

using metaworld::RandVec;

/// Takes one placement after the other: there may be more than memory holds.
using Sink = std::function<void(const RandVec&)>;

void Mt1(const PlacementsOptions& options, const Sink& sink) {
  if (options.seed > std::numeric_limits<std::uint32_t>::max())
    throw std::invalid_argument("--seed " + std::to_string(options.seed) +
                                ": mt1 takes seeds from 0 to 4294967295, as numpy does");
  if (options.count > metaworld::kMt1Placements)
    throw std::invalid_argument("--count " + std::to_string(options.count) + ": mt1 has " +
                                std::to_string(metaworld::kMt1Placements) + " placements");
  auto placements = metaworld::Mt1Placements(metaworld::tasks::FindTask(options.task),
                                             static_cast<std::uint32_t>(options.seed));
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

/// Prints rows, with the header before the first.
class Table {
 public:
  explicit Table(std::ostream* out) : out_(*out) {}

  void Add(const RandVec& placement) {
    if (!std::exchange(begun_, true)) out_ << "obj_x,obj_y,obj_z,goal_x,goal_y,goal_z\n";
    for (std::size_t i = 0; i < placement.size(); ++i)
      out_ << (i > 0 ? "," : "") << text::FormatNumber(placement[i]);
    out_ << '\n';
    if (!out_) throw std::runtime_error("cannot write the output");
  }

 private:
  std::ostream& out_;
  bool begun_ = false;  // bad options leave the output empty
};

}  // namespace

int RunPlacements(const PlacementsOptions& options, std::ostream& out) {
  try {
    Table table(&out);
    Place(options, [&table](const RandVec& placement) { table.Add(placement); });
    out << std::flush;
    if (!out) throw std::runtime_error("cannot write the output");
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
