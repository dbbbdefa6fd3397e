#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "common/messages/messages.h"

/// The two ends of the wire as interfaces, so that the learner and the actor are tested without
/// any middleware. common/dds/ implements them over Fast DDS; tests/ has an in-memory fake.
namespace metronome {

using Clock = std::chrono::steady_clock;

/// An actor's process is gone (its lease ran out or it left).
struct ActorLost {
  std::uint64_t actor_id = 0;
};
/// A sample that could not be turned into a message (bounds, lengths, protocol version).
struct BadSample {
  std::string topic;
  std::string reason;
};
/// Another learner of the same run is alive, as its RunDescription says.
struct RivalSeen {
  RunDescription description;
};
/// The rival's process is gone.
struct RivalLost {
  std::uint64_t learner_id = 0;
};
/// LearnerBus::Wake was called (Ctrl-C, an update is done).
struct Woken {};

using LearnerEvent =
    std::variant<ActorStatus, ActorLost, EpisodeMessage, BadSample, RivalSeen, RivalLost, Woken>;

/// The learner's end. Thread-safe. Bad middleware throws std::runtime_error.
class LearnerBus {
 public:
  virtual ~LearnerBus() = default;
  /// Replaces the description that present and future actors of the run see.
  virtual void Publish(const RunDescription& description) = 0;
  /// Late joiners get the last two versions. Blocks while the middleware is busy, as a description
  /// does; throws after ten seconds of it.
  virtual void Publish(const PolicySnapshot& snapshot) = 0;
  /// For whoever watches; the last one is kept for late joiners.
  virtual void Publish(const LearnerStatus& status) = 0;
  /// Queues an assignment for the actor it names. @return false if that actor is not connected.
  virtual bool Send(const EpisodeAssignment& assignment) = 0;
  /// Next event, oldest first; std::nullopt at the deadline. Events queue bounded: a slow caller
  /// pushes back on the actors, nothing is lost.
  virtual std::optional<LearnerEvent> Wait(Clock::time_point deadline) = 0;
  /// Makes Wait return Woken. May be called from any thread (not from a signal handler).
  virtual void Wake() = 0;
  /// Payload bytes sent and received so far.
  [[nodiscard]] virtual std::uint64_t bytes_sent() const = 0;
  [[nodiscard]] virtual std::uint64_t bytes_received() const = 0;
};

/// The learner that this actor saw is gone; it may come back with a higher incarnation.
struct LearnerLost {
  std::uint64_t learner_id = 0;
};

using ActorEvent =
    std::variant<RunDescription, PolicySnapshot, EpisodeAssignment, LearnerLost, BadSample, Woken>;

/// The actor's end. Thread-safe.
class ActorBus {
 public:
  enum class SendResult { kSent, kNoLearner, kClosed };
  virtual ~ActorBus() = default;
  /// Publishes a finished episode. Blocks while the reliable history is full.
  /// @return kNoLearner if no learner was heard that reads episodes (the episode is dropped: it
  ///         will be reassigned), kClosed once Close() ran.
  [[nodiscard]] virtual SendResult Send(EpisodeMessage message) = 0;
  virtual void Send(const ActorStatus& status) = 0;
  virtual std::optional<ActorEvent> Wait(Clock::time_point deadline) = 0;
  virtual void Wake() = 0;
  /// Unblocks Send; waits at most `timeout` until what was sent is acknowledged.
  virtual void Close(std::chrono::milliseconds timeout) = 0;
};

using ObserverEvent = std::variant<LearnerStatus, RunDescription, LearnerLost, BadSample>;

/// The end of someone who watches: it writes nothing, so that nobody reckons with it. Thread-safe.
class ObserverBus {
 public:
  virtual ~ObserverBus() = default;
  /// Next event, oldest first; std::nullopt at the deadline.
  virtual std::optional<ObserverEvent> Wait(Clock::time_point deadline) = 0;
};

}  // namespace metronome
