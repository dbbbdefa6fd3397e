#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

#include "common/dds/convert.h"
#include "common/dds/participant.h"
#include "common/dds/peer_watch.h"
#include "common/messages/bus.h"
#include "common/process/mutex.h"

/// Typed ends of one topic, in terms of messages. Thread-safe.
namespace metronome::dds {

using ReturnCode = eprosima::fastrtps::types::ReturnCode_t;

enum class [[nodiscard]] WriteResult{kWritten, kFull};

template <class PubSubType>
class Writer {
 public:
  using Wire = typename PubSubType::type;

  Writer(Participant* participant, const TopicProfile& profile, fdds::DataWriterListener* listener)
      : profile_(profile), writer_(participant->MakeWriter<PubSubType>(profile, listener)) {}

  /// A message as Write takes it, as often as it takes.
  /// @throws Malformed for a message beyond the wire's bounds.
  template <class Message>
  static Envelope<Wire> Pack(Message message) {
    Envelope<Wire> envelope;
    envelope.value = ToWire(std::move(message));
    return envelope;
  }

  /// Packs and writes.
  template <class Message>
  WriteResult Write(Message message) {
    Envelope<Wire> envelope = Pack(std::move(message));
    return Write(envelope);
  }

  /// Blocks at most the writer's max_blocking_time while the reliable history is full, and while
  /// other threads do. @param envelope  unchanged. @throws std::runtime_error.
  WriteResult Write(Envelope<Wire>& envelope) {
    // One at a time: threads that meet a full history together leak payloads inside Fast DDS 2.9.
    const process::MutexLock lock(mutex_);
    // Not write(void*): its bool merges a full history with a failed encode.
    const ReturnCode code = writer_->write(&envelope, fdds::HANDLE_NIL);
    if (code == ReturnCode::RETCODE_OK) return WriteResult::kWritten;
    if (code == ReturnCode::RETCODE_TIMEOUT) return WriteResult::kFull;
    throw std::runtime_error(std::string("writing ") + profile_.name + ": Fast DDS return code " +
                             std::to_string(code()));
  }

  /// Packs and writes, again and again while it is refused: Fast DDS also gives up early where it
  /// is busy itself, with a history that has room.
  /// @return kFull: it still is at `deadline`.
  template <class Message>
  WriteResult WriteUntil(Clock::time_point deadline, Message message) {
    Envelope<Wire> envelope = Pack(std::move(message));
    WriteResult result = Write(envelope);
    while (result == WriteResult::kFull && Clock::now() < deadline) {
      WaitForAcknowledgements(kRetry);  // rather than spin
      result = Write(envelope);
    }
    return result;
  }

  /// @return whether all readers have all samples before `timeout` is over.
  bool WaitForAcknowledgements(std::chrono::milliseconds timeout) {
    const auto nanoseconds = std::chrono::duration_cast<std::chrono::nanoseconds>(timeout).count();
    const eprosima::fastrtps::Duration_t duration(
        static_cast<std::int32_t>(nanoseconds / 1'000'000'000),
        static_cast<std::uint32_t>(nanoseconds % 1'000'000'000));
    return writer_->wait_for_acknowledgments(duration) == ReturnCode::RETCODE_OK;
  }

 private:
  static constexpr std::chrono::milliseconds kRetry{50};

  const TopicProfile profile_;
  process::Mutex mutex_;
  fdds::DataWriter* const writer_;
};

/// A writer's sample as a message, or why it is none.
template <class Message>
struct Taken {
  std::variant<Message, BadSample> content;
  Header header;
  bool foreign_version = false;  // content is a BadSample that names both versions
  fdds::InstanceHandle_t writer;
  double age_seconds = 0;  // since it was written, by the two hosts' clocks
};

inline double AgeSeconds(const fdds::SampleInfo& info) {
  const std::chrono::duration<double> now = std::chrono::system_clock::now().time_since_epoch();
  const std::chrono::nanoseconds written(info.source_timestamp.to_ns());
  return std::chrono::duration<double>(now - written).count();  // not in the nanoseconds of both
}

template <class PubSubType>
class Reader {
 public:
  using Wire = typename PubSubType::type;
  using Message = decltype(FromWire(std::declval<Wire>()));

  Reader(Participant* participant, const TopicProfile& profile, WriterWatch* watch,
         std::optional<std::uint64_t> only_actor_id = std::nullopt)
      : profile_(profile),
        watch_(watch),
        reader_(participant->MakeReader<PubSubType>(profile, watch, only_actor_id)) {}

  /// The oldest sample received, or std::nullopt if there is none. Never blocks.
  std::optional<Taken<Message>> Take() {
    fdds::SampleInfo info;
    do {
      Envelope<Wire> envelope;
      const std::uint64_t deaths = watch_->Deaths();  // before: a sample may come while we look
      const ReturnCode code = reader_->take_next_sample(&envelope, &info);
      if (code == ReturnCode::RETCODE_NO_DATA) {
        watch_->Drained(deaths);
        return std::nullopt;
      }
      if (code != ReturnCode::RETCODE_OK) {
        throw std::runtime_error(std::string("reading ") + profile_.name +
                                 ": Fast DDS return code " + std::to_string(code()));
      }
      if (info.valid_data) return Open(std::move(envelope), info);
    } while (true);
  }

  /// The complaint about a writer that was turned away for its quality of service.
  [[nodiscard]] BadSample Incompatible() const {
    return {profile_.name,
            "a peer offers another quality of service and is not heard: is it built from other "
            "sources?"};
  }

 private:
  Taken<Message> Open(Envelope<Wire> envelope, const fdds::SampleInfo& info) const {
    Taken<Message> taken{BadSample{profile_.name, envelope.error}, envelope.header,
                         envelope.foreign_version, info.publication_handle, AgeSeconds(info)};
    if (envelope.foreign_version) {
      taken.content = BadSample{
          profile_.name, "protocol version " + std::to_string(envelope.header.protocol_version) +
                             ", this build speaks " + std::to_string(kProtocolVersion)};
    } else if (envelope.error.empty()) {
      try {
        taken.content = FromWire(std::move(envelope.value));
      } catch (const Malformed& error) {
        taken.content = BadSample{profile_.name, error.what()};
      }
    }
    return taken;
  }

  const TopicProfile profile_;
  WriterWatch* const watch_;
  fdds::DataReader* const reader_;
};

}  // namespace metronome::dds
