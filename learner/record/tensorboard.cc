#include "learner/record/tensorboard.h"

#include <bit>
#include <chrono>
#include <cstring>

#include "learner/record/tensorboard_event.pb.h"

namespace metronome::record {
namespace {

static_assert(std::endian::native == std::endian::little, "record frames are copied as they lie");

constexpr std::size_t kLengthBytes = 8, kCrcBytes = 4;
constexpr std::size_t kFrameBytes = kLengthBytes + kCrcBytes + kCrcBytes;

// TFRecord stores checksums rotated and offset, so that a CRC over data with CRCs stays useful.
std::uint32_t MaskedCrc(std::string_view bytes) {
  return std::rotr(Crc32c(bytes), 15) + 0xa282ead8U;
}

template <typename T>
std::string Raw(T value) {
  return {reinterpret_cast<const char*>(&value), sizeof(value)};
}

std::string Record(const std::string& data) {
  const std::string length = Raw(static_cast<std::uint64_t>(data.size()));
  return length + Raw(MaskedCrc(length)) + data + Raw(MaskedCrc(data));
}

std::size_t WholeRecords(std::string_view content) {
  std::size_t at = 0;
  while (content.size() - at >= kFrameBytes) {
    std::uint64_t length = 0;
    std::memcpy(&length, content.data() + at, kLengthBytes);
    if (length > content.size() - at - kFrameBytes) break;
    at += kFrameBytes + length;
  }
  return at;
}

tensorboard::Event NewEvent() {
  tensorboard::Event event;
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  event.set_wall_time(std::chrono::duration<double>(now).count());
  return event;
}

}  // namespace

std::uint32_t Crc32c(std::string_view bytes) {
  constexpr std::uint32_t kReversedPolynomial = 0x82f63b78U;
  std::uint32_t crc = ~0U;
  for (const char byte : bytes) {
    crc ^= static_cast<std::uint8_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (crc & 1 ? kReversedPolynomial : 0);
  }
  return ~crc;
}

TensorBoardLog::TensorBoardLog(const std::string& path, std::uint64_t keep_bytes)
    : file_(path, keep_bytes, WholeRecords) {
  if (file_.size() > 0) return;
  tensorboard::Event event = NewEvent();
  event.set_file_version("brain.Event:2");
  file_.Append(Record(event.SerializeAsString()));
}

void TensorBoardLog::Append(std::uint64_t steps, const std::vector<algorithm::Metric>& metrics) {
  tensorboard::Event event = NewEvent();
  event.set_step(static_cast<std::int64_t>(steps));
  for (const algorithm::Metric& metric : metrics) {
    auto* value = event.mutable_summary()->add_value();
    value->set_tag(metric.tag);
    value->set_simple_value(std::visit([](auto v) { return static_cast<float>(v); }, metric.value));
  }
  file_.Append(Record(event.SerializeAsString()));
}

}  // namespace metronome::record
