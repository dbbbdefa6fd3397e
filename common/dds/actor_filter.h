#pragma once

#include <cstdint>
#include <fastdds/dds/topic/IContentFilterFactory.hpp>
#include <string>
#include <vector>

namespace metronome::dds {

/// The content filter of assignments: lets pass what is for one actor. Fast DDS evaluates it at the
/// writer, for each assignment and each actor, and its own SQL filter takes apart the whole sample
/// each time (15 us), which stops a learner at some dozens of actors. This one reads the 64-bit
/// number that every message begins with. Both ends must have registered it; an end that has not
/// simply sends, or gets, more. Stateless and thread-safe.
class ActorFilterFactory final : public eprosima::fastdds::dds::IContentFilterFactory {
 public:
  static constexpr const char* kClassName = "metronome.actor_id";

  /// @return the one of this process, which outlives all participants.
  static ActorFilterFactory* Get();
  /// Parameters of the filter for one actor, as create_content_filter reads them.
  static std::vector<std::string> ParametersOf(std::uint64_t actor_id);

  ReturnCode_t create_content_filter(
      const char* filter_class_name, const char* type_name,
      const eprosima::fastdds::dds::TopicDataType* data_type, const char* filter_expression,
      const ParameterSeq& filter_parameters,
      eprosima::fastdds::dds::IContentFilter*& filter_instance) override;
  ReturnCode_t delete_content_filter(
      const char* filter_class_name,
      eprosima::fastdds::dds::IContentFilter* filter_instance) override;
};

/// The 64-bit number in the third place of a serialised message, whatever its type and version.
/// @param data  [length] encapsulation and CDR. @return false if it is not there.
bool ReadMessageId(const std::uint8_t* data, std::uint32_t length, std::uint64_t* id);

}  // namespace metronome::dds
