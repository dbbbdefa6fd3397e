#include <spdlog/spdlog.h>

#include <chrono>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "common/dds/dds_bus.h"
#include "common/dds/endpoints.h"
#include "common/dds/inbox.h"
#include "common/dds/learner_sightings.h"
#include "common/process/mutex.h"

namespace metronome::dds {
namespace {

using dds::Inbox;
using dds::ReaderWatch;
using dds::WriterWatch;

class DdsLearnerBus final : public LearnerBus {
 public:
  explicit DdsLearnerBus(const BusOptions& options)
      : close_timeout_(options.close_timeout), participant_(options, "learner") {}

  ~DdsLearnerBus() override {
    const Clock::time_point end = Clock::now() + close_timeout_;
    descriptions_.WaitForAcknowledgements(close_timeout_);
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
    if (left.count() > 0) learner_statuses_.WaitForAcknowledgements(left);
  }

  void Publish(const RunDescription& description) override {
    WriteSurely(descriptions_, description, "run description");
  }
  void Publish(const PolicySnapshot& snapshot) override {
    WriteSurely(snapshots_, snapshot, "policy snapshot");
  }
  void Publish(const LearnerStatus& status) override {
    if (learner_statuses_.Write(status) == dds::WriteResult::kWritten) return;
    spdlog::warn("a status was not sent: Fast DDS does not take it");
  }

  bool Send(const EpisodeAssignment& assignment) override {
    const auto process = status_watch_.ProcessOf(assignment.actor_id);
    if (!process || !assignment_watch_.IsReadBy(*process)) return false;
    return assignments_.Write(assignment) == dds::WriteResult::kWritten;
  }

  std::optional<LearnerEvent> Wait(Clock::time_point deadline) override {
    return inbox_.Wait(deadline, [this] { return Next(); });
  }

  void Wake() override { inbox_.Wake(); }
  std::uint64_t bytes_sent() const override { return participant_.traffic().sent; }
  std::uint64_t bytes_received() const override { return participant_.traffic().received; }

 private:
  // Nothing is sent a second time by itself: without a snapshot actors would wait for ever.
  template <class Writer, class Message>
  static void WriteSurely(Writer& writer, const Message& message, const std::string& what) {
    const auto written = writer.WriteUntil(Clock::now() + kPatience, message);
    if (written == dds::WriteResult::kWritten) return;
    throw std::runtime_error("the " + what + " was not sent: Fast DDS has not taken it for " +
                             std::to_string(kPatience.count()) + " s");
  }

  static constexpr std::chrono::seconds kPatience{10};

  std::optional<LearnerEvent> Next() {
    const process::MutexLock lock(next_mutex_);
    if (inbox_.TakeWoken()) return Woken{};
    if (auto event = NextRival()) return event;
    if (auto event = NextStatus()) return event;
    if (auto taken = episodes_.Take()) {
      return std::visit([](auto& content) { return LearnerEvent(std::move(content)); },
                        taken->content);
    }
    return std::nullopt;
  }

  std::optional<LearnerEvent> NextRival() METRONOME_REQUIRES(next_mutex_) {
    const auto event = sightings_.Next();
    if (!event) return std::nullopt;
    if (const auto* description = std::get_if<RunDescription>(&*event)) {
      return RivalSeen{*description};
    }
    if (const auto* gone = std::get_if<dds::LearnerGone>(&*event)) {
      return RivalLost{gone->learner_id};
    }
    return std::get<BadSample>(*event);
  }

  std::optional<LearnerEvent> NextStatus() {
    if (auto taken = statuses_.Take()) {
      if (taken->foreign_version) {
        ActorStatus foreign;  // the caller refuses it, both versions named
        foreign.protocol_version = taken->header.protocol_version;
        foreign.incarnation = taken->header.incarnation;
        foreign.actor_id = taken->header.id;
        taken->content = foreign;
      }
      if (auto* bad = std::get_if<BadSample>(&taken->content)) return std::move(*bad);
      auto& status = std::get<ActorStatus>(taken->content);
      status.vouched_host = participant_.HostOf(taken->writer);
      status_watch_.Saw(taken->writer, status.actor_id);
      return std::move(status);
    }
    if (const auto id = status_watch_.NextLost()) return ActorLost{*id};
    if (status_watch_.TakeIncompatible()) return statuses_.Incompatible();
    return std::nullopt;
  }

  const std::chrono::milliseconds close_timeout_;
  process::Mutex next_mutex_;
  // Before the participant: no listener may be called once it is gone.
  Inbox inbox_;
  ReaderWatch assignment_watch_{&inbox_};
  WriterWatch status_watch_{&inbox_};
  WriterWatch episode_watch_{&inbox_};
  WriterWatch learner_watch_{&inbox_};
  dds::Participant participant_;
  dds::Writer<wire::RunDescriptionPubSubType> descriptions_{&participant_,
                                                            dds::kRunDescriptionTopic, nullptr};
  dds::Writer<wire::PolicySnapshotPubSubType> snapshots_{&participant_, dds::kPolicySnapshotTopic,
                                                         nullptr};
  dds::Writer<wire::EpisodeAssignmentPubSubType> assignments_{
      &participant_, dds::kEpisodeAssignmentTopic, &assignment_watch_};
  dds::Writer<wire::LearnerStatusPubSubType> learner_statuses_{&participant_,
                                                               dds::kLearnerStatusTopic, nullptr};
  dds::Reader<wire::ActorStatusPubSubType> statuses_{&participant_, dds::kActorStatusTopic,
                                                     &status_watch_};
  dds::Reader<wire::EpisodePubSubType> episodes_{&participant_, dds::kEpisodeTopic,
                                                 &episode_watch_};
  dds::LearnerSightings sightings_ METRONOME_GUARDED_BY(next_mutex_){&participant_,
                                                                     &learner_watch_};
};

}  // namespace

std::unique_ptr<LearnerBus> MakeDdsLearnerBus(const BusOptions& options) {
  return std::make_unique<DdsLearnerBus>(options);
}

}  // namespace metronome::dds
