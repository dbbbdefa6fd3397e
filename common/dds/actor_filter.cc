#include "common/dds/actor_filter.h"

#include <bit>
#include <charconv>
#include <cstring>
#include <string_view>

namespace metronome::dds {
namespace {

namespace fdds = eprosima::fastdds::dds;

constexpr std::uint32_t kIdAt = 4 + 16;  // encapsulation; uint32, padding, uint64

class ActorFilter final : public fdds::IContentFilter {
 public:
  explicit ActorFilter(std::uint64_t actor_id) : actor_id_(actor_id) {}

  /// A sample that names no actor passes: the actor reports it.
  bool evaluate(const SerializedPayload& payload, const FilterSampleInfo& /*info*/,
                const GUID_t& /*reader*/) const override {
    std::uint64_t id = 0;
    return !ReadMessageId(payload.data, payload.length, &id) || id == actor_id_;
  }

 private:
  const std::uint64_t actor_id_;
};

bool ParseId(std::string_view text, std::uint64_t* id) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *id);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

bool ReadMessageId(const std::uint8_t* data, std::uint32_t length, std::uint64_t* id) {
  if (length < kIdAt + sizeof *id) return false;
  std::memcpy(id, data + kIdAt, sizeof *id);
  const bool little_endian = (data[1] & 1) != 0;  // DDSI-RTPS 10.5: CDR_BE 0x0000, CDR_LE 0x0001
  if (little_endian != (std::endian::native == std::endian::little)) *id = __builtin_bswap64(*id);
  return true;
}

ActorFilterFactory* ActorFilterFactory::Get() {
  static ActorFilterFactory factory;
  return &factory;
}

std::vector<std::string> ActorFilterFactory::ParametersOf(std::uint64_t actor_id) {
  return {std::to_string(actor_id)};
}

ActorFilterFactory::ReturnCode_t ActorFilterFactory::create_content_filter(
    const char* /*filter_class_name*/, const char* /*type_name*/,
    const fdds::TopicDataType* /*data_type*/, const char* /*filter_expression*/,
    const ParameterSeq& filter_parameters, fdds::IContentFilter*& filter_instance) {
  std::uint64_t id = 0;
  // Parameters of readers come from the network.
  if (filter_parameters.length() != 1 || filter_parameters[0] == nullptr ||
      !ParseId(filter_parameters[0], &id)) {
    return ReturnCode_t::RETCODE_BAD_PARAMETER;
  }
  delete static_cast<ActorFilter*>(filter_instance);  // the one to be replaced, or null
  filter_instance = new ActorFilter(id);
  return ReturnCode_t::RETCODE_OK;
}

ActorFilterFactory::ReturnCode_t ActorFilterFactory::delete_content_filter(
    const char* /*filter_class_name*/, fdds::IContentFilter* filter_instance) {
  delete static_cast<ActorFilter*>(filter_instance);
  return ReturnCode_t::RETCODE_OK;
}

}  // namespace metronome::dds
