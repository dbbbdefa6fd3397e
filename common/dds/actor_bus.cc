#include <atomic>
#include <mutex>
#include <utility>

#include "common/dds/dds_bus.h"
#include "common/dds/endpoints.h"
#include "common/dds/inbox.h"
#include "common/dds/learner_sightings.h"
#include "common/dds/participant_qos.h"

namespace metronome {
namespace {

using dds::Inbox;
using dds::ReaderWatch;
using dds::WriterWatch;

class DdsActorBus final : public ActorBus {
 public:
  DdsActorBus(const BusOptions& options, std::uint64_t actor_id)
      : actor_id_(actor_id), participant_(options, dds::kActorRole) {}

  SendResult Send(EpisodeMessage message) override {
    auto sample = episodes_.Pack(std::move(message));
    while (!closed_) {
      if (!episode_watch_.HasReader()) return SendResult::kNoLearner;
      if (episodes_.Write(sample) == dds::WriteResult::kWritten) return SendResult::kSent;
      // A full history refuses early: wait for acknowledgements rather than spin.
      episodes_.WaitForAcknowledgements(kRetry);
    }
    return SendResult::kClosed;
  }

  void Send(const ActorStatus& status) override { statuses_.Write(status); }

  std::optional<ActorEvent> Wait(Clock::time_point deadline) override {
    return inbox_.Wait(deadline, [this] { return Next(); });
  }

  void Wake() override { inbox_.Wake(); }

  void Close(std::chrono::milliseconds timeout) override {
    closed_ = true;
    if (episode_watch_.HasReader()) episodes_.WaitForAcknowledgements(timeout);
  }

 private:
  static constexpr std::chrono::milliseconds kRetry{50};

  std::optional<ActorEvent> Next() {
    const std::lock_guard lock(next_mutex_);
    if (inbox_.TakeWoken()) return Woken{};
    if (auto event = NextLearner()) return event;
    if (auto taken = snapshots_.Take()) return EventOf(std::move(taken->content));
    while (auto taken = orders_.Take()) {
      const auto* order = std::get_if<EpisodeOrder>(&taken->content);
      if (order != nullptr && order->actor_id != actor_id_) continue;
      return EventOf(std::move(taken->content));
    }
    return std::nullopt;
  }

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
  std::atomic<bool> closed_{false};
  std::mutex next_mutex_;
  // Before the participant: no listener may be called once it is gone.
  Inbox inbox_;
  ReaderWatch episode_watch_{&inbox_};
  WriterWatch snapshot_watch_{&inbox_};
  WriterWatch order_watch_{&inbox_};
  WriterWatch learner_watch_{&inbox_};
  dds::Participant participant_;
  dds::Writer<wire::EpisodePubSubType> episodes_{&participant_, dds::kEpisodeTopic,
                                                 &episode_watch_};
  dds::Writer<wire::ActorStatusPubSubType> statuses_{&participant_, dds::kActorStatusTopic,
                                                     nullptr};
  dds::Reader<wire::PolicySnapshotPubSubType> snapshots_{&participant_, dds::kPolicySnapshotTopic,
                                                         &snapshot_watch_};
  dds::Reader<wire::EpisodeOrderPubSubType> orders_{&participant_, dds::kEpisodeOrderTopic,
                                                    &order_watch_, actor_id_};
  dds::LearnerSightings sightings_{&participant_, &learner_watch_};
};

}  // namespace

std::unique_ptr<ActorBus> MakeDdsActorBus(const BusOptions& options, std::uint64_t actor_id) {
  return std::make_unique<DdsActorBus>(options, actor_id);
}

}  // namespace metronome
