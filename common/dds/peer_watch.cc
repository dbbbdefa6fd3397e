#include "common/dds/peer_watch.h"

#include <algorithm>
#include <utility>

namespace metronome::dds {

void WriterWatch::Saw(const fdds::InstanceHandle_t& writer, std::uint64_t id) {
  const process::MutexLock lock(mutex_);
  std::erase(lost_, id);
  if (dead_.count(writer) > 0) {
    lost_.push_back(id);
  } else {
    // One that joined again by a new participant: the old one's end is no loss.
    std::erase_if(peers_, [&](const auto& peer) { return peer.second == id; });
    peers_[writer] = id;
  }
}

std::uint64_t WriterWatch::Deaths() const {
  const process::MutexLock lock(mutex_);
  return deaths_;
}

void WriterWatch::Drained(std::uint64_t mark) {
  const process::MutexLock lock(mutex_);
  std::erase_if(dead_, [mark](const auto& writer) { return writer.second <= mark; });
}

std::optional<std::uint64_t> WriterWatch::NextLost() {
  const process::MutexLock lock(mutex_);
  if (lost_.empty()) return std::nullopt;
  const std::uint64_t id = lost_.front();
  lost_.pop_front();
  return id;
}

std::vector<std::uint64_t> WriterWatch::Untold() const {
  const process::MutexLock lock(mutex_);
  std::vector<std::uint64_t> ids(lost_.begin(), lost_.end());
  for (const auto& [writer, peer] : peers_) ids.push_back(peer);
  return ids;
}

bool WriterWatch::TakeIncompatible() {
  const process::MutexLock lock(mutex_);
  return std::exchange(incompatible_, false);
}

std::optional<ParticipantKey> WriterWatch::ProcessOf(std::uint64_t id) const {
  const process::MutexLock lock(mutex_);
  for (const auto& [writer, peer] : peers_) {
    if (peer == id) return ParticipantOf(writer);
  }
  return std::nullopt;
}

std::vector<ParticipantKey> WriterWatch::Processes() const {
  const process::MutexLock lock(mutex_);
  std::vector<ParticipantKey> processes;
  for (const auto& [writer, peer] : peers_) processes.push_back(ParticipantOf(writer));
  return processes;
}

void WriterWatch::on_data_available(fdds::DataReader* /*reader*/) { inbox_->Notify(); }

void WriterWatch::on_subscription_matched(fdds::DataReader* /*reader*/,
                                          const fdds::SubscriptionMatchedStatus& status) {
  const fdds::InstanceHandle_t& writer = status.last_publication_handle;
  {
    const process::MutexLock lock(mutex_);
    if (status.current_count_change > 0) {
      dead_.erase(writer);
      return;
    }
    dead_[writer] = ++deaths_;
    const auto peer = peers_.find(writer);
    if (peer == peers_.end()) return;
    lost_.push_back(peer->second);
    peers_.erase(peer);
  }
  inbox_->Notify();
}

void WriterWatch::on_requested_incompatible_qos(
    fdds::DataReader* /*reader*/, const fdds::RequestedIncompatibleQosStatus& /*status*/) {
  {
    const process::MutexLock lock(mutex_);
    incompatible_ = true;
  }
  inbox_->Notify();
}

bool ReaderWatch::IsReadBy(const ParticipantKey& process) const {
  const process::MutexLock lock(mutex_);
  return readers_.count(process) > 0;
}

bool ReaderWatch::IsReadByAny(const std::vector<ParticipantKey>& processes) const {
  return std::any_of(processes.begin(), processes.end(),
                     [this](const ParticipantKey& process) { return IsReadBy(process); });
}

void ReaderWatch::on_publication_matched(fdds::DataWriter* /*writer*/,
                                         const fdds::PublicationMatchedStatus& status) {
  const ParticipantKey process = ParticipantOf(status.last_subscription_handle);
  {
    const process::MutexLock lock(mutex_);
    if (status.current_count_change > 0) {
      readers_.insert(process);
    } else if (const auto found = readers_.find(process); found != readers_.end()) {
      readers_.erase(found);
    }
  }
  inbox_->Notify();
}

}  // namespace metronome::dds
