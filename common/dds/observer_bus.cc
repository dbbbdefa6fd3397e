#include <utility>

#include "common/dds/dds_bus.h"
#include "common/dds/endpoints.h"
#include "common/dds/inbox.h"
#include "common/dds/learner_sightings.h"
#include "common/dds/participant_qos.h"
#include "common/process/mutex.h"

namespace metronome::dds {
namespace {

using dds::Inbox;
using dds::WriterWatch;

class DdsObserverBus final : public ObserverBus {
 public:
  explicit DdsObserverBus(const BusOptions& options) : participant_(options, dds::kObserverRole) {}

  std::optional<ObserverEvent> Wait(Clock::time_point deadline) override {
    return inbox_.Wait(deadline, [this] { return Next(); });
  }

 private:
  template <class Content>
  static ObserverEvent EventOf(Content content) {
    return std::visit([](auto& event) { return ObserverEvent(std::move(event)); }, content);
  }

  std::optional<ObserverEvent> Next() {
    const process::MutexLock lock(next_mutex_);
    // A learner's last words come before the news that it is gone.
    if (auto taken = statuses_.Take()) {
      if (auto* status = std::get_if<LearnerStatus>(&taken->content)) {
        status->age_seconds = taken->age_seconds;
      }
      return EventOf(std::move(taken->content));
    }
    const auto event = sightings_.Next();
    if (!event) return std::nullopt;
    if (const auto* gone = std::get_if<dds::LearnerGone>(&*event)) {
      return LearnerLost{gone->learner_id};
    }
    if (const auto* description = std::get_if<RunDescription>(&*event)) return *description;
    return std::get<BadSample>(*event);
  }

  process::Mutex next_mutex_;
  // Before the participant: no listener may be called once it is gone.
  Inbox inbox_;
  WriterWatch status_watch_{&inbox_};
  WriterWatch learner_watch_{&inbox_};
  dds::Participant participant_;
  dds::Reader<wire::LearnerStatusPubSubType> statuses_{&participant_, dds::kLearnerStatusTopic,
                                                       &status_watch_};
  dds::LearnerSightings sightings_ METRONOME_GUARDED_BY(next_mutex_){&participant_,
                                                                     &learner_watch_};
};

}  // namespace

std::unique_ptr<ObserverBus> MakeDdsObserverBus(const BusOptions& options) {
  return std::make_unique<DdsObserverBus>(options);
}

}  // namespace metronome::dds
