#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "common/messages/episode.h"

namespace metronome::collect {

/// The accepted episodes, batch by batch, and the count of how often each number of the run entered
/// an update. Not thread-safe; batches that were taken are shared read-only.
class BatchStore {
 public:
  using Batch = std::shared_ptr<const std::vector<Episode>>;

  /// @param episodes_per_update  E.
  /// @param updates_before       made before this process, as the checkpoint says.
  BatchStore(std::uint64_t episodes_per_update, std::uint64_t updates_before);

  /// @throws std::logic_error if the number is there already.
  void Put(Episode episode);
  /// The kept episode of this number, or nullptr: it is in the making, or of a batch long past.
  [[nodiscard]] const Episode* Find(std::uint64_t number) const;

  /// Takes a kept episode out again. @return nothing if it is not there, or has been taken.
  std::optional<Episode> Withdraw(std::uint64_t number);

  /// Batch `version` in number order; it stays findable until the next one is taken.
  /// @throws std::logic_error unless it is complete.
  Batch Take(std::uint64_t version);
  /// The batch has entered an update: counts each of its numbers.
  void CountEntered(const std::vector<Episode>& batch);

  struct Accounting {
    std::uint64_t total = 0;          // numbers of the updates made
    std::uint64_t entered = 0;        // numbers that entered an update
    std::uint64_t once = 0;           // of these: exactly one
    std::uint64_t before_resume = 0;  // of these: as the checkpoint says
    [[nodiscard]] bool exact() const { return once == total && entered == total; }
  };
  /// @param updates  made, all starts together.
  [[nodiscard]] Accounting Account(std::uint64_t updates) const;

 private:
  std::uint64_t episodes_per_update_;
  std::vector<std::uint32_t> entered_;  // updates that each number has entered, as far as it goes
  std::uint64_t before_;                // numbers used before this process
  std::map<std::uint64_t, Episode> making_;
  Batch taken_;
};

}  // namespace metronome::collect
