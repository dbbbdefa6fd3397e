#include "learner/collect/episode_counts.h"

#include <cctype>
#include <cstddef>

namespace metronome::collect {
namespace {

// Whoever sends garbage must not make us keep ever more of it.
constexpr std::size_t kMaxKinds = 64;
constexpr std::size_t kManyActors = 1024;  // as many as a status lists (idl/metronome.idl)
constexpr std::size_t kMaxActors = 8192;   // more than are there at once
constexpr std::size_t kMaxKindLength = 120;

// "step 17 names head 3" -> "step # names head #": reasons of one kind are counted together.
std::string KindOf(const std::string& reason) {
  std::string kind;
  for (const char c : reason) {
    const bool digit = std::isdigit(static_cast<unsigned char>(c)) != 0;
    if (digit && !kind.empty() && kind.back() == '#') continue;
    kind += digit ? '#' : c;
    if (kind.size() >= kMaxKindLength) break;
  }
  return kind;
}

template <class Value>
Value& Bounded(std::map<std::string, Value>& table, const std::string& key, std::size_t most) {
  const bool fits = table.contains(key) || table.size() < most;
  return table[fits ? key : "others"];
}

}  // namespace

void EpisodeCounts::CountAccepted(const std::string& actor) {
  ++accepted;
  ++Bounded(by_actor, actor, kMaxActors).accepted;
}

void EpisodeCounts::CountDuplicate(const std::string& actor, bool differs) {
  ++duplicates;
  if (differs) ++differing_duplicates;
  ++Bounded(by_actor, actor, kMaxActors).duplicates;
}

void EpisodeCounts::CountRejected(const std::string& actor, const std::string& reason) {
  ++rejected;
  ++Bounded(rejected_by_reason, KindOf(reason), kMaxKinds);
  ++Bounded(by_actor, actor, kMaxActors).rejected;
}

bool EpisodeCounts::HasManyActors() const { return by_actor.size() >= kManyActors; }

void EpisodeCounts::KeepActors(const std::set<std::string>& present) {
  std::erase_if(by_actor, [&](const auto& entry) { return !present.contains(entry.first); });
}

}  // namespace metronome::collect
