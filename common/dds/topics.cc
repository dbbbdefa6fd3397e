#include "common/dds/topics.h"

namespace metronome::dds {
namespace {

namespace fdds = eprosima::fastdds::dds;
using eprosima::fastrtps::Duration_t;

// The default of 3 s would delay the last acknowledgement by as much.
const Duration_t kHeartbeat{0, 50'000'000};
// One try of write(); callers retry, so that closing is noticed.
const Duration_t kMaxBlocking{0, 20'000'000};
constexpr std::int32_t kMaxFilteredActors = 1024;  // beyond it actors filter for themselves

/// Both sides share these: policies of equal type and meaning in writer and reader.
template <class Qos>
void SetShared(const TopicProfile& topic, std::int32_t depth, Qos* qos) {
  qos->reliability().kind = fdds::RELIABLE_RELIABILITY_QOS;
  qos->durability().kind =
      topic.transient_local ? fdds::TRANSIENT_LOCAL_DURABILITY_QOS : fdds::VOLATILE_DURABILITY_QOS;
  qos->history().kind = topic.keep_all ? fdds::KEEP_ALL_HISTORY_QOS : fdds::KEEP_LAST_HISTORY_QOS;
  qos->history().depth = depth;
  qos->resource_limits().max_samples = depth;
  qos->resource_limits().max_instances = 1;  // no topic has a key
  qos->resource_limits().max_samples_per_instance = depth;
  qos->resource_limits().allocated_samples = 1;
  qos->resource_limits().extra_samples = 1;
  qos->endpoint().history_memory_policy =
      eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  qos->data_sharing().off();
}

}  // namespace

fdds::DataWriterQos WriterQos(const TopicProfile& topic) {
  fdds::DataWriterQos qos = fdds::DATAWRITER_QOS_DEFAULT;
  SetShared(topic, topic.writer_depth, &qos);
  qos.reliability().max_blocking_time = kMaxBlocking;
  qos.reliable_writer_qos().times.heartbeatPeriod = kHeartbeat;
  qos.reliable_writer_qos().times.initialHeartbeatDelay = {0, 10'000'000};
  qos.reliable_writer_qos().times.nackResponseDelay = {0, 5'000'000};
  qos.reliable_writer_qos().disable_heartbeat_piggyback = topic.to_one_reader;
  qos.writer_resource_limits().reader_filters_allocation.maximum = kMaxFilteredActors;
  return qos;
}

fdds::DataReaderQos ReaderQos(const TopicProfile& topic) {
  fdds::DataReaderQos qos = fdds::DATAREADER_QOS_DEFAULT;
  SetShared(topic, topic.reader_depth, &qos);
  qos.reliable_reader_qos().times.heartbeatResponseDelay = {0, 5'000'000};
  qos.reliable_reader_qos().times.initialAcknackDelay = {0, 10'000'000};
  return qos;
}

}  // namespace metronome::dds
