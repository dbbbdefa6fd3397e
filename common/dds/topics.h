#pragma once

#include <cstdint>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>

#include "idl/metronomePubSubTypes.h"

/// The six topics and their quality of service: the table of idl/README.md in code.
namespace metronome::dds {

struct TopicProfile {
  const char* name;
  bool transient_local;       // late readers get what the writer still keeps
  bool keep_all;              // bounded by the depths, with back-pressure; else keep-last
  std::int32_t writer_depth;  // samples a writer holds at most
  std::int32_t reader_depth;  // samples a reader holds at most, of all writers together
  std::uint32_t usual_bytes;  // size that buffers start with
  /// Each sample is for one of many readers. The writer then tells readers what they lack in its
  /// periodic heartbeats alone: with every write, all the others would ask for what is not theirs.
  bool to_one_reader = false;
};

/// Readers of the two keep-last topics hold more than one sample: rival learners share the topic.
inline constexpr TopicProfile kRunDescriptionTopic{
    "metronome/run_description", true, false, 1, 8, 1024};
inline constexpr TopicProfile kPolicySnapshotTopic{
    "metronome/policy_snapshot", true, false, 2, 8, 128 * 1024};
inline constexpr TopicProfile kEpisodeAssignmentTopic{
    "metronome/episode_assignment", false, true, 4096, 1024, 256, true};
/// The learner has room for an episode of each of 256 actors that end at once (24 MB): what comes
/// beyond that is dropped, asked for and sent again.
inline constexpr TopicProfile kEpisodeTopic{"metronome/episode", false, true, 32, 256, 96 * 1024};
inline constexpr TopicProfile kActorStatusTopic{
    "metronome/actor_status", false, false, 4, 256, 512};
inline constexpr TopicProfile kLearnerStatusTopic{
    "metronome/learner_status", true, false, 1, 8, 4096};

/// Reliable, data sharing off, finite resource limits.
eprosima::fastdds::dds::DataWriterQos WriterQos(const TopicProfile& topic);
eprosima::fastdds::dds::DataReaderQos ReaderQos(const TopicProfile& topic);

}  // namespace metronome::dds
