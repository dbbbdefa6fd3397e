#pragma once

#include <cstring>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <optional>
#include <stdexcept>
#include <vector>

#include "common/dds/convert.h"
#include "common/dds/endpoints.h"
#include "common/dds/inbox.h"
#include "common/dds/participant_qos.h"
#include "common/dds/peer_watch.h"

/// Peers that send what no correct peer sends: samples of any bytes on the topics of a run.
namespace metronome::test {

using Bytes = std::vector<char>;

/// A type of any name whose samples are the bytes that they are given.
class RawType final : public dds::fdds::TopicDataType {
 public:
  using Payload = eprosima::fastrtps::rtps::SerializedPayload_t;

  explicit RawType(const char* name) {
    setName(name);
    m_typeSize = 1024;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }
  bool serialize(void* data, Payload* payload) override {
    const auto& bytes = *static_cast<Bytes*>(data);
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<std::uint32_t>(bytes.size());
    return true;
  }
  bool deserialize(Payload*, void*) override { return false; }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<Bytes*>(data)->size()); };
  }
  void* createData() override { return new Bytes(); }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, dds::fdds::InstanceHandle_t*, bool) override { return false; }
};

/// The bytes that a correct peer would send. @throws std::runtime_error.
template <class PubSubType, class Message>
Bytes Encode(const Message& message) {
  PubSubType type;
  auto sample = dds::ToWire(message);
  eprosima::fastrtps::rtps::SerializedPayload_t payload(type.getSerializedSizeProvider(&sample)());
  if (!type.serialize(&sample, &payload)) throw std::runtime_error("cannot encode");
  const char* data = reinterpret_cast<const char*>(payload.data);
  return Bytes(data, data + payload.length);
}

/// Publishes raw bytes on one topic of a run.
class RawWriter {
 public:
  /// This process's own permissions (options.security) do not let it write the topic.
  class Forbidden : public std::runtime_error {
   public:
    using std::runtime_error::runtime_error;
  };

  /// @param type_name  that the topic's readers match by: PubSubType().getName().
  RawWriter(const BusOptions& options, const dds::TopicProfile& profile, const char* type_name)
      : factory_(dds::fdds::DomainParticipantFactory::get_instance()),
        participant_(factory_->create_participant(options.domain,
                                                  dds::ParticipantQos(options, "attacker"))) {
    dds::fdds::TypeSupport(new RawType(type_name)).register_type(participant_);
    dds::fdds::PublisherQos qos = dds::fdds::PUBLISHER_QOS_DEFAULT;
    qos.partition().push_back(options.run_name.c_str());
    writer_ = participant_->create_publisher(qos)->create_datawriter(
        participant_->create_topic(profile.name, type_name, dds::fdds::TOPIC_QOS_DEFAULT),
        Qos(profile), &watch_);
    if (writer_ != nullptr) return;
    Delete();
    throw Forbidden(profile.name);
  }
  ~RawWriter() { Delete(); }
  RawWriter(const RawWriter&) = delete;
  RawWriter& operator=(const RawWriter&) = delete;

  /// @return false at the deadline.
  bool WaitForReader(Clock::time_point deadline) {
    const auto there = [this] { return HasReader() ? std::optional(true) : std::nullopt; };
    return inbox_.Wait(deadline, there).has_value();
  }

  /// One at a time, so that keep-last topics carry each.
  /// @return false if it was not acknowledged within 20 s.
  bool Write(Bytes bytes) {
    while (writer_->write(&bytes, dds::fdds::HANDLE_NIL) != dds::ReturnCode::RETCODE_OK) {
      if (!HasReader()) return false;
    }
    return writer_->wait_for_acknowledgments({20, 0}) == dds::ReturnCode::RETCODE_OK;
  }

 private:
  [[nodiscard]] bool HasReader() const {
    dds::fdds::PublicationMatchedStatus status;
    writer_->get_publication_matched_status(status);
    return status.current_count > 0;
  }

  void Delete() {
    participant_->delete_contained_entities();
    factory_->delete_participant(participant_);
  }

  static dds::fdds::DataWriterQos Qos(const dds::TopicProfile& profile) {
    dds::fdds::DataWriterQos qos = dds::WriterQos(profile);
    qos.reliable_writer_qos().times.heartbeatPeriod = {0, 2'000'000};  // acknowledged soon
    return qos;
  }

  dds::Inbox inbox_;
  dds::ReaderWatch watch_{&inbox_};
  dds::fdds::DomainParticipantFactory* const factory_;
  dds::fdds::DomainParticipant* const participant_;
  dds::fdds::DataWriter* writer_ = nullptr;
};

}  // namespace metronome::test
