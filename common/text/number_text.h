#pragma once

#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

/// Numbers to and from text, free of locale. Pure functions.
namespace metronome::text {

/// Shortest text that reads back as the same double ("0.1", "5e-04", "nan", "inf").
std::string FormatNumber(double value);

/// The whole of `text` as a T (integer or floating point); std::nullopt if it is anything else or
/// out of T's range. No blanks, no leading '+'; floating point takes nan and inf.
template <typename T>
std::optional<T> ParseNumber(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace metronome::text
