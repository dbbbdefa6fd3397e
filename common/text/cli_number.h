#pragma once

#include <CLI/CLI.hpp>
#include <concepts>
#include <limits>
#include <string>
#include <type_traits>

#include "common/text/number_text.h"

namespace metronome::text {

/// A number from `low` to `high` on the command line, read as those of a configuration are. CLI11
/// by itself takes -1 for 2^64 - 1, 010 for eight, and nan for inside any range. For transform,
/// which hands on what was read.
template <typename T>
CLI::Validator Number(T low = std::numeric_limits<T>::lowest(),
                      T high = std::numeric_limits<T>::max()) {
  const auto text_of = [](T value) {
    if constexpr (std::integral<T>)
      return std::to_string(value);
    else
      return FormatNumber(value);
  };
  const std::string range = text_of(low) + " to " + text_of(high);
  return CLI::Validator(
      [=](std::string& text) {
        const auto value = ParseNumber<T>(text);
        if (!value || !(low <= *value && *value <= high)) {
          return "\"" + text + "\" must be " +
                 (std::integral<T> ? "an integer from " : "a number from ") + range;
        }
        text = text_of(*value);
        return std::string();
      },
      "");
}

}  // namespace metronome::text
