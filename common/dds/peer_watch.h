#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "common/dds/inbox.h"
#include "common/dds/participant.h"
#include "common/process/mutex.h"

namespace metronome::dds {

/// Listens to one reader: tells the inbox of new samples, and notices when the process behind a
/// writer is gone (its participant's lease ran out, or it left). A process that was stopped for
/// longer than the lease is gone, and matched anew once it goes on. Thread-safe.
///
/// Not by the writers' own liveliness: in Fast DDS 2.9 any participant's assertion of the automatic
/// kind revives the writers of all others.
class WriterWatch final : public fdds::DataReaderListener {
 public:
  explicit WriterWatch(Inbox* inbox) : inbox_(inbox) {}

  /// A sample of peer `id` was taken. If its writer is gone already, the peer is lost after it.
  void Saw(const fdds::InstanceHandle_t& writer, std::uint64_t id);
  /// How many writers have left so far: a mark for Drained.
  [[nodiscard]] std::uint64_t Deaths() const;
  /// The reader had no sample left after Deaths() was `mark`, so none of a writer that had left by
  /// then. One that left since may have left a sample behind.
  void Drained(std::uint64_t mark);
  /// The id of a peer that is gone; oldest first. Ask after its samples were taken: they come
  /// first, so that a peer's last words are heard.
  std::optional<std::uint64_t> NextLost();
  /// Peers whose loss was not told yet: those that are gone, and those that live.
  [[nodiscard]] std::vector<std::uint64_t> Untold() const;
  /// Whether a writer was turned away for its quality of service since this last returned true.
  bool TakeIncompatible();
  /// The process that wrote the last sample seen of the peer, while it lives.
  std::optional<ParticipantKey> ProcessOf(std::uint64_t id) const;
  /// Of all peers that were heard and live.
  [[nodiscard]] std::vector<ParticipantKey> Processes() const;

  void on_data_available(fdds::DataReader* reader) override;
  void on_subscription_matched(fdds::DataReader* reader,
                               const fdds::SubscriptionMatchedStatus& status) override;
  void on_requested_incompatible_qos(fdds::DataReader* reader,
                                     const fdds::RequestedIncompatibleQosStatus& status) override;

 private:
  Inbox* const inbox_;
  mutable process::Mutex mutex_;
  // Alive writers that were heard.
  std::map<fdds::InstanceHandle_t, std::uint64_t> peers_ METRONOME_GUARDED_BY(mutex_);
  std::uint64_t deaths_ METRONOME_GUARDED_BY(mutex_) = 0;
  // Writers whose samples may be left over, and which death each was.
  std::map<fdds::InstanceHandle_t, std::uint64_t> dead_ METRONOME_GUARDED_BY(mutex_);
  // At most one entry a writer that was heard.
  std::deque<std::uint64_t> lost_ METRONOME_GUARDED_BY(mutex_);
  bool incompatible_ METRONOME_GUARDED_BY(mutex_) = false;
};

/// Which processes read what one writer writes. Thread-safe.
class ReaderWatch final : public fdds::DataWriterListener {
 public:
  explicit ReaderWatch(Inbox* inbox) : inbox_(inbox) {}

  [[nodiscard]] bool IsReadBy(const ParticipantKey& process) const;
  [[nodiscard]] bool IsReadByAny(const std::vector<ParticipantKey>& processes) const;

  void on_publication_matched(fdds::DataWriter* writer,
                              const fdds::PublicationMatchedStatus& status) override;

 private:
  Inbox* const inbox_;
  mutable process::Mutex mutex_;
  std::multiset<ParticipantKey> readers_ METRONOME_GUARDED_BY(mutex_);
};

}  // namespace metronome::dds
