#include <algorithm>
#include <atomic>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "common/dds/dds_bus.h"
#include "common/dds/endpoints.h"
#include "common/dds/inbox.h"
#include "common/dds/learner_sightings.h"
#include "common/dds/participant_qos.h"
#include "common/process/mutex.h"

namespace metronome::dds {
namespace {

using dds::Inbox;
using dds::ReaderWatch;
using dds::WriterWatch;

/// One participant with its endpoints. Thread-safe but for Next.
class Ends {
 public:
  Ends(const BusOptions& options, std::uint64_t actor_id, Inbox* inbox)
      : actor_id_(actor_id),
        episode_watch_(inbox),
        snapshot_watch_(inbox),
        assignment_watch_(inbox),
        learner_watch_(inbox),
        participant_(options, dds::kActorRole) {}

  /// Whether a learner was heard and reads our episodes. Others may read them too: a tool that
  /// looks on is no learner.
  [[nodiscard]] bool HasLearner() const {
    return episode_watch_.IsReadByAny(learner_watch_.Processes());
  }

  /// Learners that were heard here and whose loss Next has not told.
  [[nodiscard]] std::vector<std::uint64_t> UntoldLearners() const {
    return learner_watch_.Untold();
  }

  ActorBus::SendResult Send(EpisodeMessage message, const std::atomic<bool>& closed) {
    auto sample = episodes_.Pack(std::move(message));
    while (!closed) {
      if (!HasLearner()) return ActorBus::SendResult::kNoLearner;
      if (episodes_.Write(sample) == dds::WriteResult::kWritten) return ActorBus::SendResult::kSent;
      // A full history refuses early: wait for acknowledgements rather than spin.
      episodes_.WaitForAcknowledgements(kRetry);
    }
    return ActorBus::SendResult::kClosed;
  }

  void Send(const ActorStatus& status) {
    (void)statuses_.Write(status);  // refused: the next one comes within a second
  }

  void WaitForAcknowledgements(std::chrono::milliseconds timeout) {
    if (HasLearner()) episodes_.WaitForAcknowledgements(timeout);
  }

  std::optional<ActorEvent> Next() {
    if (auto event = NextLearner()) return event;
    if (auto taken = snapshots_.Take()) return EventOf(std::move(taken->content));
    while (auto taken = assignments_.Take()) {
      const auto* assignment = std::get_if<EpisodeAssignment>(&taken->content);
      if (assignment != nullptr && assignment->actor_id != actor_id_) continue;
      return EventOf(std::move(taken->content));
    }
    return std::nullopt;
  }

 private:
  static constexpr std::chrono::milliseconds kRetry{50};

  std::optional<ActorEvent> NextLearner() {
    const auto event = sightings_.Next();
    if (!event) return std::nullopt;
    if (const auto* description = std::get_if<RunDescription>(&*event)) return *description;
    if (const auto* gone = std::get_if<dds::LearnerGone>(&*event)) {
      return LearnerLost{gone->learner_id};
    }
    return std::get<BadSample>(*event);
  }

  template <class Content>
  static ActorEvent EventOf(Content content) {
    return std::visit([](auto& event) { return ActorEvent(std::move(event)); }, content);
  }

  const std::uint64_t actor_id_;
  // Before the participant: no listener may be called once it is gone.
  ReaderWatch episode_watch_;
  WriterWatch snapshot_watch_;
  WriterWatch assignment_watch_;
  WriterWatch learner_watch_;
  dds::Participant participant_;
  dds::Writer<wire::EpisodePubSubType> episodes_{&participant_, dds::kEpisodeTopic,
                                                 &episode_watch_};
  dds::Writer<wire::ActorStatusPubSubType> statuses_{&participant_, dds::kActorStatusTopic,
                                                     nullptr};
  dds::Reader<wire::PolicySnapshotPubSubType> snapshots_{&participant_, dds::kPolicySnapshotTopic,
                                                         &snapshot_watch_};
  dds::Reader<wire::EpisodeAssignmentPubSubType> assignments_{
      &participant_, dds::kEpisodeAssignmentTopic, &assignment_watch_, actor_id_};
  dds::LearnerSightings sightings_{&participant_, &learner_watch_};
};

/// An actor that has lost its learner joins with a new participant. With the old one it would not
/// find a learner that has not lost it in turn (packets of one direction were lost for longer than
/// the lease, or the learner was stopped): to such a learner it is known, so Fast DDS 2.9 does not
/// tell it of the learner's endpoints again.
class DdsActorBus final : public ActorBus {
 public:
  DdsActorBus(const BusOptions& options, std::uint64_t actor_id)
      : options_(options), actor_id_(actor_id) {
    Renew();
  }

  SendResult Send(EpisodeMessage message) override {
    const auto current = ends();
    return current ? current->Send(std::move(message), closed_) : SendResult::kNoLearner;
  }
  void Send(const ActorStatus& status) override {
    if (const auto current = ends()) current->Send(status);
  }

  std::optional<ActorEvent> Wait(Clock::time_point deadline) override {
    while (true) {
      auto event = inbox_.Wait(std::min(deadline, renew_at()), [this] { return Next(); });
      if (event || Clock::now() >= deadline) return event;
    }
  }

  void Wake() override { inbox_.Wake(); }

  void Close(std::chrono::milliseconds timeout) override {
    closed_ = true;
    if (const auto current = ends()) current->WaitForAcknowledgements(timeout);
  }

 private:
  // Without a word of a learner for so long: whatever half-known state there may be is given up. A
  // learner whose endpoints are known may not know ours.
  static constexpr std::chrono::seconds kRenewEvery{10};

  std::optional<ActorEvent> Next() {
    const process::MutexLock lock(next_mutex_);
    if (inbox_.TakeWoken()) return Woken{};
    if (auto lost = NextUntold()) return lost;
    auto event = ends()->Next();
    const Clock::time_point now = Clock::now();
    if (ends()->HasLearner()) {
      renew_at_ = now + kRenewEvery;
    } else if (now >= renew_at_ || (event && std::holds_alternative<LearnerLost>(*event))) {
      Renew();
    }
    return event ? event : NextUntold();
  }

  std::optional<ActorEvent> NextUntold() METRONOME_REQUIRES(next_mutex_) {
    if (untold_.empty()) return std::nullopt;
    const LearnerLost lost{untold_.front()};
    untold_.pop_front();
    return lost;
  }

  void Renew() METRONOME_REQUIRES(next_mutex_) {
    const process::MutexLock lock(ends_mutex_);
    // The new one tells of no loss of those that only the old one knew; whoever lives is heard
    // anew.
    if (ends_) {
      const auto untold = ends_->UntoldLearners();
      untold_.insert(untold_.end(), untold.begin(), untold.end());
    }
    // First: the new one may need its shared-memory port. A worker inside Send keeps the old one
    // until its write returns; both are there then, as two participants of one process.
    ends_.reset();
    ends_ = std::make_shared<Ends>(options_, actor_id_, &inbox_);
    renew_at_ = Clock::now() + kRenewEvery;
  }

  [[nodiscard]] std::shared_ptr<Ends> ends() const {
    const process::MutexLock lock(ends_mutex_);
    return ends_;
  }
  [[nodiscard]] Clock::time_point renew_at() {
    const process::MutexLock lock(next_mutex_);
    return renew_at_;
  }

  const BusOptions options_;
  const std::uint64_t actor_id_;
  std::atomic<bool> closed_{false};
  process::Mutex next_mutex_;
  Inbox inbox_;
  std::deque<std::uint64_t> untold_ METRONOME_GUARDED_BY(next_mutex_);  // learners of earlier ends
  Clock::time_point renew_at_ METRONOME_GUARDED_BY(next_mutex_);
  mutable process::Mutex ends_mutex_;  // held while there are none
  std::shared_ptr<Ends> ends_ METRONOME_GUARDED_BY(ends_mutex_);
};

}  // namespace

std::unique_ptr<ActorBus> MakeDdsActorBus(const BusOptions& options, std::uint64_t actor_id) {
  return std::make_unique<DdsActorBus>(options, actor_id);
}

}  // namespace metronome::dds
