#pragma once

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <utility>
#include <vector>

#include "common/messages/bus.h"

namespace metronome::test {

/// The actor's end of the wire in memory: a test plays the learner.
class FakeActorBus final : public ActorBus {
 public:
  /// The test's side.
  void Push(ActorEvent event) {
    const std::lock_guard lock(mutex_);
    events_.push_back(std::move(event));
    changed_.notify_all();
  }

  /// Blocks until `condition(episodes, statuses)` holds. @return false after 20 s.
  template <class Condition>
  bool WaitUntil(Condition condition) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::seconds(20),
                             [&] { return condition(episodes_, statuses_); });
  }

  std::vector<EpisodeMessage> episodes() const {
    const std::lock_guard lock(mutex_);
    return episodes_;
  }
  bool closed() const {
    const std::lock_guard lock(mutex_);
    return closed_;
  }

  /// The actor's side.
  SendResult Send(EpisodeMessage message) override {
    const std::lock_guard lock(mutex_);
    if (closed_) return SendResult::kClosed;
    episodes_.push_back(std::move(message));
    changed_.notify_all();
    return SendResult::kSent;
  }
  void Send(const ActorStatus& status) override {
    const std::lock_guard lock(mutex_);
    statuses_.push_back(status);
    changed_.notify_all();
  }
  std::optional<ActorEvent> Wait(Clock::time_point deadline) override {
    std::unique_lock lock(mutex_);
    if (!changed_.wait_until(lock, deadline, [&] { return !events_.empty(); })) return std::nullopt;
    ActorEvent event = std::move(events_.front());
    events_.pop_front();
    return event;
  }
  void Wake() override { Push(Woken{}); }
  void Close(std::chrono::milliseconds /*timeout*/) override {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<ActorEvent> events_;
  std::vector<EpisodeMessage> episodes_;
  std::vector<ActorStatus> statuses_;
  bool closed_ = false;
};

}  // namespace metronome::test
