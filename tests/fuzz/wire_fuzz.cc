/// Samples of one topic, as bytes from anybody on the network: WIRE is the type's name. What is let
/// through must encode to the same message again.
#include <fuzzer/FuzzedDataProvider.h>

#include <cstdint>
#include <cstdlib>
#include <memory>

#include "common/dds/convert.h"
#include "common/dds/wire_type.h"

namespace metronome::dds {
namespace {

using PubSubType = wire::WIRE;
using Type = WireType<PubSubType>;
using Sample = Envelope<Type::Wire>;
using Message = decltype(FromWire(std::declval<Type::Wire>()));

/// @return whether the bytes are a message.
bool Decode(Type& type, Type::Payload& payload, Message* message) {
  Sample sample;
  if (!type.deserialize(&payload, &sample)) std::abort();  // would be lost inside Fast DDS
  if (!sample.error.empty() || sample.foreign_version) return false;
  try {
    *message = FromWire(std::move(sample.value));
    return true;
  } catch (const Malformed&) {
    return false;
  }
}

void Run(const std::uint8_t* data, std::size_t size) {
  static Type type(1024, std::make_shared<Traffic>());
  Type::Payload payload(static_cast<std::uint32_t>(size));
  std::copy_n(data, size, payload.data);
  payload.length = static_cast<std::uint32_t>(size);
  Message message;
  if (!Decode(type, payload, &message)) return;

  Sample again;
  again.value = ToWire(Message(message));
  Type::Payload encoded(type.getSerializedSizeProvider(&again)());
  if (!type.serialize(&again, &encoded)) std::abort();
  Message copy;
  if (!Decode(type, encoded, &copy)) std::abort();
}

}  // namespace
}  // namespace metronome::dds

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  metronome::dds::Run(data, size);
  return 0;
}
