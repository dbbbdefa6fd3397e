#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// "Did you mean ...?" for names that people type. Pure functions.
namespace metronome::text {

/// Insertions, deletions, substitutions and swaps of neighbours that turn `a` into `b` (optimal
/// string alignment); bytes compare without regard to ASCII case, '_' equals '-'.
std::size_t EditDistance(std::string_view a, std::string_view b);

/// The candidate that `name` most likely meant, or std::nullopt if none is near: at most a third
/// of the longer name's length (at least 1) apart, or `name` is a part of just one candidate or one
/// candidate a part of it. The first of equals wins.
std::optional<std::string> NearMiss(std::string_view name,
                                    const std::vector<std::string>& candidates);

/// "A, B, C".
std::string JoinNames(const std::vector<std::string>& names);

/// `unknown KIND "NAME"; did you mean "NEAR"? Known: A, B, C` - without the question when nothing
/// is near.
std::string UnknownName(std::string_view kind, std::string_view name,
                        const std::vector<std::string>& candidates);
/// The same with the near miss given.
std::string UnknownName(std::string_view kind, std::string_view name,
                        const std::vector<std::string>& candidates,
                        const std::optional<std::string>& near);

}  // namespace metronome::text
