#pragma once

#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

/// Numbers to and from text, free of locale. Pure functions.
namespace metronome::text {

/// Shortest text that reads back as the same double ("0.1", "5e-04", "nan", "inf").
std::string FormatNumber(double value);

/// "1 actor", "2 actors". @param noun  one whose plural ends in s.
std::string Counted(std::uint64_t count, std::string_view noun);

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
