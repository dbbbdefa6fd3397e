#pragma once

#include <cstdint>
#include <string>
#include <variant>

namespace metronome::algorithm {

/// One number of an update, for progress.csv and TensorBoard.
struct Metric {
  std::string column;  // of progress.csv; wall-clock ones are `fps` and those that begin with wall_
  std::string tag;     // of TensorBoard; wall-clock ones begin with wall/
  std::variant<std::uint64_t, double> value;
  std::string meaning;  // for people, as learner/README.md has it
};

}  // namespace metronome::algorithm
