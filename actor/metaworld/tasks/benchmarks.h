#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "actor/metaworld/placement.h"
#include "actor/metaworld/task_spec.h"

/// The official benchmarks of many tasks (metaworld 3.1.1, env_dict.py and __init__.py). Pure
/// functions.
namespace metronome::metaworld::tasks {

/// Names of tasks in the official order, which says which task draws its placements after which.
struct Benchmark {
  std::string name;                // "mt10"
  std::vector<std::string> train;  // all that an MT benchmark has
  std::vector<std::string> test;   // of ML: tasks to adapt to
};

/// MT10, MT50, ML10, ML45.
const std::vector<Benchmark>& AllBenchmarks();

/// @throws std::invalid_argument for any other name, with the near miss and the list.
const Benchmark& FindBenchmark(const std::string& name);

struct TaskPlacements {
  const TaskSpec* task;
  std::vector<RandVec> placements;  // kMt1Placements
};

/// The official placements of a benchmark's `train` or `test` tasks, number for number. One stream
/// goes through all of them, so a task has others than in MT1 with that seed, unless it is the
/// first; train and test each begin the stream anew.
std::vector<TaskPlacements> BenchmarkPlacements(const std::vector<std::string>& tasks,
                                                std::uint32_t seed);

}  // namespace metronome::metaworld::tasks
