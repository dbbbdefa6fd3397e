#pragma once

#include <functional>
#include <map>
#include <stdexcept>
#include <utility>
#include <variant>
#include <vector>

#include "common/messages/bus.h"
#include "learner/run/background.h"

/// The learner's bus without any middleware, in virtual time: waiting takes none, every test runs
/// the same way each time. Single-threaded.
namespace metronome::testing {

class FakeBus final : public LearnerBus {
 public:
  using TimePoint = Clock::time_point;
  using Action = std::function<void()>;

  [[nodiscard]] TimePoint now() const { return now_; }
  void After(std::chrono::milliseconds delay, LearnerEvent event) {
    due_.emplace(now_ + delay, std::move(event));
  }
  /// Runs `action` inside a Wait when its time has come.
  void CallAfter(std::chrono::milliseconds delay, Action action) {
    due_.emplace(now_ + delay, std::move(action));
  }

  void Publish(const RunDescription& description) override {
    descriptions.push_back(description);
    if (on_description) on_description(description);
  }
  void Publish(const PolicySnapshot& snapshot) override { snapshots.push_back(snapshot); }
  void Publish(const LearnerStatus& status) override { statuses.push_back(status); }
  bool Send(const EpisodeAssignment& assignment) override {
    assignments.push_back(assignment);
    return !on_assignment || on_assignment(assignment);
  }
  std::optional<LearnerEvent> Wait(TimePoint deadline) override {
    if (++waits > kMaxWaits) throw std::logic_error("the loop spins, or the run never ends");
    while (!due_.empty() && due_.begin()->first <= deadline) {
      auto entry = due_.extract(due_.begin());
      now_ = std::max(now_, entry.key());
      if (auto* event = std::get_if<LearnerEvent>(&entry.mapped())) return std::move(*event);
      std::get<Action>(entry.mapped())();
    }
    now_ = std::max(now_, deadline);
    return std::nullopt;
  }
  void Wake() override { After(std::chrono::milliseconds(0), Woken{}); }
  [[nodiscard]] std::uint64_t bytes_sent() const override { return 0; }
  [[nodiscard]] std::uint64_t bytes_received() const override { return 0; }

  std::vector<RunDescription> descriptions;
  std::vector<PolicySnapshot> snapshots;
  std::vector<EpisodeAssignment> assignments;
  std::vector<LearnerStatus> statuses;
  std::function<void(const RunDescription&)> on_description;
  std::function<bool(const EpisodeAssignment&)>
      on_assignment;  // @return whether the actor is connected
  int waits = 0;

 private:
  static constexpr int kMaxWaits = 20000;
  TimePoint now_{std::chrono::hours(1)};
  std::multimap<TimePoint, std::variant<LearnerEvent, Action>> due_;
};

/// Does its work inside a later Wait of the bus, `duration` after Start.
class FakeBackground final : public run::Background {
 public:
  explicit FakeBackground(FakeBus& bus) : bus_(bus) {}

  void Start(std::function<void()> work) override {
    if (running) throw std::logic_error("other work still runs");
    running = true;
    bus_.CallAfter(duration, [this, work = std::move(work)] {
      work();
      running = false;
    });
  }
  void Wait() override {}

  std::chrono::milliseconds duration{1000};
  bool running = false;

 private:
  FakeBus& bus_;
};

}  // namespace metronome::testing
