#include "common/dds/peer_watch.h"

namespace metronome::dds {
namespace {

std::optional<std::uint64_t> PopFront(std::deque<std::uint64_t>* ids) {
  if (ids->empty()) return std::nullopt;
  const std::uint64_t id = ids->front();
  ids->pop_front();
  return id;
}

}  // namespace

bool WriterWatch::Saw(const fdds::InstanceHandle_t& writer, std::uint64_t id) {
  const std::lock_guard lock(mutex_);
  if (dead_.count(writer) > 0) return false;
  peers_[writer] = id;
  return true;
}

void WriterWatch::Drained() {
  const std::lock_guard lock(mutex_);
  dead_.clear();
}

std::optional<std::uint64_t> WriterWatch::NextLost() {
  const std::lock_guard lock(mutex_);
  return PopFront(&lost_);
}

std::optional<std::uint64_t> WriterWatch::NextRevived() {
  const std::lock_guard lock(mutex_);
  return PopFront(&revived_);
}

std::optional<ParticipantKey> WriterWatch::ProcessOf(std::uint64_t id) const {
  const std::lock_guard lock(mutex_);
  for (const auto& [writer, peer] : peers_) {
    if (peer == id) return ParticipantOf(writer);
  }
  return std::nullopt;
}

void WriterWatch::Lose(const fdds::InstanceHandle_t& writer, Cause cause) {
  {
    const std::lock_guard lock(mutex_);
    dead_.insert(writer);
    if (cause == Cause::kGone) silent_.erase(writer);
    const auto peer = peers_.find(writer);
    if (peer == peers_.end()) return;
    if (cause == Cause::kSilent) silent_.insert(*peer);
    lost_.push_back(peer->second);
    peers_.erase(peer);
  }
  inbox_->Notify();
}

void WriterWatch::Revive(const fdds::InstanceHandle_t& writer) {
  {
    const std::lock_guard lock(mutex_);
    dead_.erase(writer);
    const auto peer = silent_.find(writer);
    if (peer == silent_.end()) return;
    revived_.push_back(peer->second);
    peers_.insert(*peer);
    silent_.erase(peer);
  }
  inbox_->Notify();
}

void WriterWatch::on_data_available(fdds::DataReader* /*reader*/) { inbox_->Notify(); }

void WriterWatch::on_subscription_matched(fdds::DataReader* /*reader*/,
                                          const fdds::SubscriptionMatchedStatus& status) {
  if (status.current_count_change < 0) Lose(status.last_publication_handle, Cause::kGone);
}

void WriterWatch::on_liveliness_changed(fdds::DataReader* /*reader*/,
                                        const eprosima::fastrtps::LivelinessChangedStatus& status) {
  if (status.not_alive_count_change > 0) {
    Lose(status.last_publication_handle, Cause::kSilent);
  } else if (status.alive_count_change > 0) {
    Revive(status.last_publication_handle);
  }
}

bool ReaderWatch::HasReader() const {
  const std::lock_guard lock(mutex_);
  return !readers_.empty();
}

bool ReaderWatch::IsReadBy(const ParticipantKey& process) const {
  const std::lock_guard lock(mutex_);
  return readers_.count(process) > 0;
}

void ReaderWatch::on_publication_matched(fdds::DataWriter* /*writer*/,
                                         const fdds::PublicationMatchedStatus& status) {
  const ParticipantKey process = ParticipantOf(status.last_subscription_handle);
  {
    const std::lock_guard lock(mutex_);
    if (status.current_count_change > 0) {
      readers_.insert(process);
    } else if (const auto found = readers_.find(process); found != readers_.end()) {
      readers_.erase(found);
    }
  }
  inbox_->Notify();
}

}  // namespace metronome::dds
