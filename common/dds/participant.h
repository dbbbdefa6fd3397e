#pragma once

#include <cstdint>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "common/dds/peer_hosts.h"
#include "common/dds/shared_memory.h"
#include "common/dds/topics.h"
#include "common/dds/wire_type.h"
#include "common/dds/workarounds/discovery_client.h"
#include "common/messages/bus_options.h"

namespace metronome::dds {

namespace fdds = eprosima::fastdds::dds;

ParticipantKey ParticipantOf(const fdds::InstanceHandle_t& endpoint);

/// A DDS participant with one publisher and one subscriber in the run's partition, and the factory
/// of their endpoints. Owns everything it makes. Thread-safe once the endpoints are made.
class Participant {
 public:
  /// @param role  "learner" or "actor": part of the name that DDS tools show.
  /// @throws std::invalid_argument for bad options and for what this machine lacks (loopback,
  /// shared
  ///         memory), std::runtime_error if Fast DDS will not start.
  Participant(const BusOptions& options, const std::string& role);
  /// Deletes all endpoints first. No listener is called any more once this returns.
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  /// @param listener  may be null; must outlive the participant. @throws std::runtime_error.
  template <class PubSubType>
  fdds::DataWriter* MakeWriter(const TopicProfile& profile, fdds::DataWriterListener* listener) {
    return MakeWriter(Register<PubSubType>(profile), profile, listener);
  }

  /// @param only_actor_id  content filter: samples for other actors never come out.
  template <class PubSubType>
  fdds::DataReader* MakeReader(const TopicProfile& profile, fdds::DataReaderListener* listener,
                               std::optional<std::uint64_t> only_actor_id = std::nullopt) {
    return MakeReader(Register<PubSubType>(profile), profile, listener, only_actor_id);
  }

  /// Whether the endpoint is one of this participant's own.
  [[nodiscard]] bool Owns(const fdds::InstanceHandle_t& endpoint) const;
  /// Of the participant that an endpoint belongs to.
  [[nodiscard]] std::string HostOf(const fdds::InstanceHandle_t& endpoint) const {
    return hosts_.HostOf(ParticipantOf(endpoint));
  }
  [[nodiscard]] const Traffic& traffic() const { return *traffic_; }

 private:
  template <class PubSubType>
  fdds::Topic* Register(const TopicProfile& profile) {
    return MakeTopic(profile,
                     fdds::TypeSupport(new WireType<PubSubType>(profile.usual_bytes, traffic_)));
  }
  fdds::Topic* MakeTopic(const TopicProfile& profile, const fdds::TypeSupport& type);
  fdds::DataWriter* MakeWriter(fdds::Topic* topic, const TopicProfile& profile,
                               fdds::DataWriterListener* listener);
  fdds::DataReader* MakeReader(fdds::Topic* topic, const TopicProfile& profile,
                               fdds::DataReaderListener* listener,
                               std::optional<std::uint64_t> only_actor_id);
  void DeleteAll();

  // These outlive the participant, whose listeners they are.
  PeerHosts hosts_;
  std::optional<workarounds::DiscoveryClient> discovery_;  // with Discovery Servers
  std::unique_ptr<fdds::DomainParticipantListener> listener_;
  std::optional<SharedMemoryNote> memory_;  // outlives the participant, of whose files it tells
  std::shared_ptr<Traffic> traffic_ = std::make_shared<Traffic>();
  std::optional<std::uint16_t> listens_on_;  // with TCP, the learner's port
  fdds::DomainParticipant* participant_ = nullptr;
  fdds::Publisher* publisher_ = nullptr;
  fdds::Subscriber* subscriber_ = nullptr;
};

}  // namespace metronome::dds
