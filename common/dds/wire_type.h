#pragma once

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <string>

#include "common/messages/messages.h"
#include "idl/metronomePubSubTypes.h"

namespace metronome::dds {

/// Payload bytes of one bus so far. Thread-safe.
struct Traffic {
  std::atomic<std::uint64_t> sent{0};
  std::atomic<std::uint64_t> received{0};
};

/// The first three members of every wire type, in every protocol version.
struct Header {
  std::uint32_t protocol_version = 0;
  std::uint64_t incarnation = 0;
  std::uint64_t id = 0;
};

/// The type of writers and readers: a sample, or why the bytes received are none.
template <class Wire>
struct Envelope {
  Wire value;
  Header header;
  bool foreign_version = false;  // the header alone was read
  std::string error;             // not empty: `value` is meaningless
};

/// A generated type support whose deserialize accepts any bytes: what they are not is told in the
/// envelope instead of being lost inside Fast DDS (or thrown through it).
/// The name on the wire is the generated one. As thread-safe as Fast DDS needs.
template <class PubSubType>
class WireType final : public PubSubType {
 public:
  using Wire = typename PubSubType::type;
  using Payload = eprosima::fastrtps::rtps::SerializedPayload_t;

  /// @param usual_bytes  buffers start at this size and grow on demand up to the type's bounds.
  WireType(std::uint32_t usual_bytes, std::shared_ptr<Traffic> traffic)
      : traffic_(std::move(traffic)) {
    this->m_typeSize = usual_bytes;
    // Other vendors match by type name; Fast DDS's type objects are of an older draft than theirs.
    this->auto_fill_type_object(false);
    this->auto_fill_type_information(false);
  }

  bool serialize(void* data, Payload* payload) override {
    if (!PubSubType::serialize(&static_cast<Envelope<Wire>*>(data)->value, payload)) return false;
    traffic_->sent += payload->length;
    return true;
  }

  bool deserialize(Payload* payload, void* data) override {
    auto* envelope = static_cast<Envelope<Wire>*>(data);
    *envelope = Envelope<Wire>{};
    traffic_->received += payload->length;
    try {
      Decode(payload, envelope);
    } catch (const std::exception& error) {
      envelope->error = std::string("undecodable: ") + error.what();
    }
    return true;
  }

  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return PubSubType::getSerializedSizeProvider(&static_cast<Envelope<Wire>*>(data)->value);
  }

  void* createData() override { return new Envelope<Wire>(); }
  void deleteData(void* data) override { delete static_cast<Envelope<Wire>*>(data); }
  bool is_bounded() const override { return false; }

 private:
  static constexpr std::uint32_t kEncapsulationBytes = 4;
  static constexpr std::uint32_t kMaxPadding = 3;  // DDSI-RTPS: payloads end on 4 bytes

  void Decode(Payload* payload, Envelope<Wire>* envelope) {
    envelope->header = ReadHeader(payload);
    if (envelope->header.protocol_version != kProtocolVersion) {
      envelope->foreign_version = true;
      return;
    }
    if (!PubSubType::deserialize(payload, &envelope->value)) {
      envelope->error = "truncated at " + std::to_string(payload->length) + " bytes";
      return;
    }
    const auto used = static_cast<std::uint32_t>(Wire::getCdrSerializedSize(envelope->value)) +
                      kEncapsulationBytes;
    if (payload->length < used || payload->length - used > kMaxPadding) {
      envelope->error = std::to_string(payload->length) + " bytes where its bounded fields take " +
                        std::to_string(used);
    }
  }

  static Header ReadHeader(Payload* payload) {
    namespace cdr = eprosima::fastcdr;
    cdr::FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->length);
    cdr::Cdr reader(buffer, cdr::Cdr::DEFAULT_ENDIAN, cdr::Cdr::DDS_CDR);
    reader.read_encapsulation();
    Header header;
    reader >> header.protocol_version >> header.incarnation >> header.id;
    return header;
  }

  std::shared_ptr<Traffic> traffic_;
};

}  // namespace metronome::dds
