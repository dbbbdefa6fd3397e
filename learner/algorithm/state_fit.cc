#include "learner/algorithm/state_fit.h"

#include "learner/algorithm/algorithm_factory.h"

namespace metronome::algorithm {

void StateFit::Refuse(const std::string& what) const {
  throw UnusableState("its state of " + name_ + " has another shape: " + what);
}

void StateFit::Size(std::size_t size, std::size_t wanted, const std::string& what) const {
  if (size == wanted) return;
  Refuse(what + " has " + std::to_string(size) + " numbers, its configuration asks for " +
         std::to_string(wanted));
}

void StateFit::Statistics(const std::vector<policy::RunningStatistics>& statistics,
                          std::size_t tasks, std::size_t dimensions,
                          const std::string& what) const {
  if (statistics.size() != tasks) {
    Refuse(what + " are of " + std::to_string(statistics.size()) +
           " tasks, its configuration has " + std::to_string(tasks));
  }
  for (const policy::RunningStatistics& of_task : statistics) {
    const bool empty = of_task.mean.empty() && of_task.m2.empty() && of_task.count == 0;
    if (empty) continue;
    Size(of_task.mean.size(), dimensions, what);
    Size(of_task.m2.size(), dimensions, what);
  }
}

}  // namespace metronome::algorithm
