#include "actor/placements.h"

#include <iostream>
#include <limits>
#include <stdexcept>
#include <vector>

#include "actor/metaworld/placement.h"
#include "actor/rollout.h"
#include "common/near_miss.h"
#include "common/number_text.h"
#include "common/task_names.h"

namespace metronome {
namespace {

using metaworld::RandVec;

std::vector<RandVec> Mt1(const PlacementsOptions& options) {
  if (options.seed > std::numeric_limits<std::uint32_t>::max())
    throw std::invalid_argument("--seed " + std::to_string(options.seed) +
                                ": mt1 takes seeds from 0 to 4294967295, as numpy does");
  if (options.count > metaworld::kMt1Placements)
    throw std::invalid_argument("--count " + std::to_string(options.count) + ": mt1 has " +
                                std::to_string(metaworld::kMt1Placements) + " placements");
  auto placements = metaworld::Mt1Placements(metaworld::FindTask(options.task),
                                             static_cast<std::uint32_t>(options.seed));
  if (options.count > 0) placements.resize(options.count);
  return placements;
}

std::vector<RandVec> OfTraining(const PlacementsOptions& options, Placements mode,
                                std::uint64_t count) {
  RunConfig config;
  config.mutable_environment()->set_task(CanonicalTaskName(options.task));
  config.mutable_environment()->set_placements(mode);
  config.set_seed(options.seed);
  std::vector<RandVec> placements;
  for (std::uint64_t number = 0; number < count; ++number)
    placements.push_back(TrainingPlacement(config, number));
  return placements;
}

std::vector<RandVec> Placed(const PlacementsOptions& options) {
  const auto count_or = [&options](std::uint64_t other) {
    return options.count > 0 ? options.count : other;
  };
  if (options.mode == "random") return OfTraining(options, PLACEMENTS_RANDOM, count_or(10));
  if (options.mode == "fixed") return OfTraining(options, PLACEMENTS_FIXED, count_or(1));
  if (options.mode == "mt1") return Mt1(options);
  throw std::invalid_argument(UnknownName("mode", options.mode, {"random", "fixed", "mt1"}));
}

}  // namespace

int RunPlacements(const PlacementsOptions& options, std::ostream& out) {
  try {
    const std::vector<RandVec> placements = Placed(options);
    out << "obj_x,obj_y,obj_z,goal_x,goal_y,goal_z\n";
    for (const RandVec& placement : placements) {
      for (std::size_t i = 0; i < placement.size(); ++i)
        out << (i > 0 ? "," : "") << FormatNumber(placement[i]);
      out << '\n';
    }
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

}  // namespace metronome
