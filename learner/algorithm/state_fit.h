#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "common/policy/running_statistics.h"

namespace metronome::algorithm {

/// Whether the numbers of an algorithm's state are as many as its configuration asks for.
/// All throw UnusableState (algorithm_factory.h) naming what does not fit.
class StateFit {
 public:
  /// @param name  the algorithm's.
  explicit StateFit(std::string name) : name_(std::move(name)) {}

  void Size(std::size_t size, std::size_t wanted, const std::string& what) const;
  /// Each task's statistics are empty, or have `dimensions`.
  void Statistics(const std::vector<policy::RunningStatistics>& statistics, std::size_t tasks,
                  std::size_t dimensions, const std::string& what) const;
  /// @throws UnusableState always. @param what  a sentence.
  [[noreturn]] void Refuse(const std::string& what) const;

 private:
  std::string name_;
};

}  // namespace metronome::algorithm
