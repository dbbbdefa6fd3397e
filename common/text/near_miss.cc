#include "common/text/near_miss.h"

#include <algorithm>
#include <cctype>

namespace metronome::text {
namespace {

char Fold(char c) {
  return c == '_' ? '-' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}

std::string Fold(std::string_view text) {
  std::string folded(text);
  std::transform(folded.begin(), folded.end(), folded.begin(), [](char c) { return Fold(c); });
  return folded;
}

// The one candidate that contains, or is contained in, `name`; names under 3 bytes say too little.
std::optional<std::string> OnlyPart(std::string_view name,
                                    const std::vector<std::string>& candidates) {
  std::optional<std::string> found;
  const std::string folded = Fold(name);
  if (folded.size() < 3) return std::nullopt;
  for (const std::string& candidate : candidates) {
    const std::string other = Fold(candidate);
    if (other.size() < 3) continue;
    if (other.find(folded) == std::string::npos && folded.find(other) == std::string::npos)
      continue;
    if (found) return std::nullopt;
    found = candidate;
  }
  return found;
}

}  // namespace

std::size_t EditDistance(std::string_view a, std::string_view b) {
  const std::string x = Fold(a), y = Fold(b);
  std::vector<std::vector<std::size_t>> d(x.size() + 1, std::vector<std::size_t>(y.size() + 1));
  for (std::size_t i = 0; i <= x.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= y.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= x.size(); ++i) {
    for (std::size_t j = 1; j <= y.size(); ++j) {
      d[i][j] = std::min(
          {d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (x[i - 1] == y[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && x[i - 1] == y[j - 2] && x[i - 2] == y[j - 1]) {
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
      }
    }
  }
  return d[x.size()][y.size()];
}

std::optional<std::string> NearMiss(std::string_view name,
                                    const std::vector<std::string>& candidates) {
  std::optional<std::string> best;
  std::size_t best_distance = 0;
  for (const std::string& candidate : candidates) {
    const std::size_t distance = EditDistance(name, candidate);
    const std::size_t allowed =
        std::max<std::size_t>(1, std::max(name.size(), candidate.size()) / 3);
    if (distance > allowed || (best && distance >= best_distance)) continue;
    best = candidate;
    best_distance = distance;
  }
  return best ? best : OnlyPart(name, candidates);
}

std::string JoinNames(const std::vector<std::string>& names) {
  std::string joined;
  for (const std::string& name : names) {
    if (!joined.empty()) joined += ", ";
    joined += name;
  }
  return joined;
}

std::string UnknownName(std::string_view kind, std::string_view name,
                        const std::vector<std::string>& candidates) {
  return UnknownName(kind, name, candidates, NearMiss(name, candidates));
}

std::string UnknownName(std::string_view kind, std::string_view name,
                        const std::vector<std::string>& candidates,
                        const std::optional<std::string>& near) {
  std::string message = "unknown " + std::string(kind) + " \"" + std::string(name) + "\"";
  message += near ? "; did you mean \"" + *near + "\"? Known: " : ". Known: ";
  return message + JoinNames(candidates);
}

}  // namespace metronome::text
