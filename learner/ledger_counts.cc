#include "learner/ledger_counts.h"

#include <cctype>
#include <cstddef>

namespace metronome {
namespace {

// Whoever sends garbage must not make us keep ever more of it.
constexpr std::size_t kMaxKinds = 64;
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
Value& Bounded(std::map<std::string, Value>& table, const std::string& key) {
  const bool fits = table.contains(key) || table.size() < kMaxKinds;
  return table[fits ? key : "others"];
}

}  // namespace

void LedgerCounts::CountAccepted(const std::string& actor) {
  ++accepted;
  ++Bounded(by_actor, actor).accepted;
}

void LedgerCounts::CountDuplicate(const std::string& actor, bool differs) {
  ++duplicates;
  if (differs) ++differing_duplicates;
  ++Bounded(by_actor, actor).duplicates;
}

void LedgerCounts::CountRejected(const std::string& actor, const std::string& reason) {
  ++rejected;
  ++Bounded(rejected_by_reason, KindOf(reason));
  ++Bounded(by_actor, actor).rejected;
}

}  // namespace metronome
