#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "learner/collect/assignments/assignment_rules.h"

namespace metronome::collect::assignments {

/// Where each number of the run is: open (to be handed out), out (with one actor or, when late,
/// several), arrived (being judged) or accepted, once. It leaves the book when its batch is learnt
/// from. Pure bookkeeping: no time, no messages, no episodes. Not thread-safe.
class NumberBook {
 public:
  /// An actor that was asked for a number, or brought it.
  struct Player {
    std::uint64_t actor_id = 0;
    std::string host;
  };
  struct Number {
    enum class State { kOpen, kOut, kArrived, kAccepted };
    State state = State::kOpen;
    std::vector<std::uint64_t> holders;  // actors that play it, latest last
    std::vector<Player> asked;  // the last that were ever asked for it, all holders among them
    std::uint32_t tries = 0;    // times that it was handed out
    std::vector<Player> heard;  // brought it, and another is to play it too: not asked again
    std::vector<std::string> vouchers;  // once accepted: hosts that brought what stands
    bool disputed = false;              // those who were heard differ
    [[nodiscard]] bool WasHeardOn(const std::string& host) const;
    /// Whether this one may be asked for it: has not brought it yet and, if it is disputed, is on
    /// another host.
    [[nodiscard]] bool MayBePlayedBy(std::uint64_t actor_id, const std::string& host) const;
  };

  /// The claim of an actor that brings a number.
  struct Claim {
    enum class Standing {
      kWanted,     // it was assigned to this actor and is missing
      kDuplicate,  // it has been brought before: by others and accepted (or learnt from), or by it
      kNotAssigned,  // not assigned to this actor, or not assignable yet
    };
    Standing standing = Standing::kNotAssigned;
    std::string host;  // of the actor when it was asked; empty if it was not, or that is long past
    std::uint64_t weights_version = 0;  // that the episode is played under
  };

  /// Actors that are remembered of those who were asked for one number and did not bring it.
  static constexpr std::size_t kAskedKept = 64;

  /// @throws std::invalid_argument if a count is 0 or first_version exceeds updates_total.
  explicit NumberBook(const AssignmentRules& rules);

  [[nodiscard]] Claim ClaimOf(std::uint64_t number, std::uint64_t actor_id) const;

  /// The actor is asked for it. @return false if somebody was before and nothing came of it.
  bool HandOut(std::uint64_t number, const Player& player);
  /// This one does not play it any more; a number that nobody plays is open again, unless it is
  /// here.
  void TakeBack(std::uint64_t number, std::uint64_t actor_id);

  /// A wanted number is here and being judged: nobody else is asked for it. One of the next four
  /// follows. @throws std::logic_error if it is not missing.
  void Arrive(std::uint64_t number);
  /// It is in its batch. @param vouchers  hosts that brought what stands. Also of a number that
  /// another was asked for and has not brought. @throws std::logic_error if it is accepted already.
  void Accept(std::uint64_t number, std::vector<std::string> vouchers);
  /// It was no good: open again, unless another plays it.
  void PutBack(std::uint64_t number);
  /// It stays, but somebody else is to play it too. @param disputed  on a host that was not heard.
  void AskAnother(std::uint64_t number, const Player& heard, bool disputed);
  /// As if nobody had brought it. Also of an accepted number.
  void Reopen(std::uint64_t number);

  /// Open numbers that nobody has brought, and those that somebody else is to play too.
  [[nodiscard]] const std::set<std::uint64_t>& open() const { return open_; }
  [[nodiscard]] const std::set<std::uint64_t>& open_again() const { return open_again_; }
  /// nullptr if it is not in the book.
  [[nodiscard]] const Number* Find(std::uint64_t number) const;
  /// Accepted numbers that no other host vouches for.
  [[nodiscard]] std::vector<std::uint64_t> OnTheWordOf(const std::string& host) const;
  /// Episodes of the batch that are accepted so far; E: all of them.
  [[nodiscard]] std::uint64_t AcceptedOf(std::uint64_t batch) const;

  /// Batch version - 1 has been learnt from: its numbers leave the book, batch version + overlap
  /// may be assigned. @throws std::logic_error unless that batch was complete and version is next.
  void Publish(std::uint64_t version);

 private:
  void OpenBatches();
  void Open(std::uint64_t number);
  void Close(std::uint64_t number);

  AssignmentRules rules_;
  std::uint64_t version_;     // latest weights
  std::uint64_t next_batch_;  // first batch that is not in numbers_ yet
  std::map<std::uint64_t, Number> numbers_;
  std::set<std::uint64_t> open_;
  std::set<std::uint64_t> open_again_;
  std::map<std::uint64_t, std::uint64_t> accepted_of_batch_;
};

}  // namespace metronome::collect::assignments
