#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>

namespace metronome::collect {

/// Counts of assignments and samples in this incarnation.
struct EpisodeCounts {
  struct ByActor {
    std::uint64_t accepted = 0;
    std::uint64_t rejected = 0;
    std::uint64_t duplicates = 0;
    bool operator==(const ByActor&) const = default;
  };
  std::uint64_t stale = 0;       // of another incarnation; nobody waits for them
  std::uint64_t reassigned = 0;  // numbers reassigned: lost, late, doubtful
  std::uint64_t accepted = 0;
  std::uint64_t duplicates = 0;  // of accepted numbers, differing ones among them
  std::uint64_t differing_duplicates = 0;
  std::uint64_t rejected = 0;
  std::map<std::string, std::uint64_t> rejected_by_reason;  // numbers in reasons are shown as #
  // By name as given at joining. Of the actors that are there, and of some that left: see
  // KeepActors.
  std::map<std::string, ByActor> by_actor;

  void CountAccepted(const std::string& actor);
  void CountDuplicate(const std::string& actor, bool differs);
  void CountRejected(const std::string& actor, const std::string& reason);

  /// `by_actor` has grown so large that those who left are to be forgotten.
  [[nodiscard]] bool HasManyActors() const;
  /// Forgets what `by_actor` says of others than `present`; the sums stay.
  void KeepActors(const std::set<std::string>& present);
};

}  // namespace metronome::collect
