#include "common/dds/participant.h"

#include <fastrtps/attributes/LibrarySettingsAttributes.h>
#include <fastrtps/xmlparser/XMLProfileManager.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/log/Log.hpp>
#include <fastdds/dds/topic/ContentFilteredTopic.hpp>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "common/dds/actor_filter.h"
#include "common/dds/machine.h"
#include "common/dds/participant_qos.h"
#include "common/dds/security/security.h"
#include "common/dds/tcp.h"
#include "common/dds/workarounds/lease_race_guard.h"
#include "common/dds/workarounds/surroundings.h"
#include "common/dds/workarounds/tcp_connections.h"

namespace metronome::dds {
namespace {

template <class Pointer>
Pointer Made(Pointer entity, const std::string& what) {
  if (entity == nullptr) throw std::runtime_error("Fast DDS did not make the " + what);
  return entity;
}

void Check(const eprosima::fastrtps::types::ReturnCode_t& code, const std::string& what) {
  using ReturnCode = eprosima::fastrtps::types::ReturnCode_t;
  if (code != ReturnCode::RETCODE_OK) {
    throw std::runtime_error(what + ": Fast DDS return code " + std::to_string(code()));
  }
}

/// Writes Fast DDS' own messages to our log. By default they go to standard output, which
/// belongs to results.
class LogForwarder final : public fdds::LogConsumer {
 public:
  void Consume(const fdds::Log::Entry& entry) override {
    log_->log(LevelOf(entry.kind), "Fast DDS, {}: {}", entry.context.category, entry.message);
  }

 private:
  static spdlog::level::level_enum LevelOf(fdds::Log::Kind kind) {
    if (kind == fdds::Log::Kind::Error) return spdlog::level::err;
    return kind == fdds::Log::Kind::Warning ? spdlog::level::warn : spdlog::level::info;
  }

  // Kept: Fast DDS may have a last word when spdlog has let go of its own.
  const std::shared_ptr<spdlog::logger> log_ = spdlog::default_logger();
};

void TakeOverLog() {
  static std::once_flag once;
  std::call_once(once, [] {
    fdds::Log::ClearConsumers();
    fdds::Log::RegisterConsumer(std::make_unique<LogForwarder>());
  });
}

/// Notes who the others are, and says that somebody was turned away, who to himself and to others
/// looks like one that is not there.
class Listener final : public fdds::DomainParticipantListener {
 public:
  /// @param inner  may be null. Both must outlive the listener.
  Listener(PeerHosts* hosts, workarounds::DiscoveryClient* inner) : hosts_(*hosts) {
    if (inner != nullptr) inner_ = inner;
  }

  void on_participant_discovery(fdds::DomainParticipant* participant,
                                workarounds::Discovered&& discovered) override {
    hosts_.Note(discovered);
    inner_->on_participant_discovery(participant, std::move(discovered));
  }

  void onParticipantAuthentication(
      fdds::DomainParticipant* /*participant*/,
      eprosima::fastrtps::rtps::ParticipantAuthenticationInfo&& info) override {
    static std::atomic<int> times{0};  // a few a process: outsiders try again for ever
    if (info.status == info.AUTHORIZED_PARTICIPANT || times++ >= kMostTimes) return;
    spdlog::warn(
        "turned away a process of this DDS domain whose identity is not good here: it has no "
        "--security, or one that another authority made, or that is expired or revoked");
  }

 private:
  static constexpr int kMostTimes = 3;
  PeerHosts& hosts_;
  workarounds::LeaseRaceGuard guard_;
  workarounds::LeaseRaceGuard* inner_ = &guard_;
};

/// Buses of one process talk through the transport, so that tests see what machines see.
void SwitchIntraprocessDeliveryOff() {
  eprosima::fastrtps::LibrarySettingsAttributes settings;
  settings.intraprocess_delivery = eprosima::fastrtps::INTRAPROCESS_OFF;
  eprosima::fastrtps::xmlparser::XMLProfileManager::library_settings(settings);
}

}  // namespace

ParticipantKey ParticipantOf(const fdds::InstanceHandle_t& endpoint) {
  ParticipantKey key;
  for (std::size_t i = 0; i < key.size(); ++i) key[i] = endpoint.value[i];
  return key;
}

Participant::Participant(const BusOptions& options, const std::string& role)
    : hosts_(!options.security.empty()) {
  CheckBusOptions(options);
  security::CheckIdentity(options, role);
  CheckLoopback(options.network);
  TakeOverLog();
  workarounds::WarnOfIgnoredSurroundings();
  SwitchIntraprocessDeliveryOff();
  WarnOfInterfaces(options.network);
  if (options.transport == Transport::kSharedMemory) {
    memory_.emplace(options.run_name, options.domain, role);
  }
  if (!options.discovery_servers.empty()) {
    discovery_.emplace(options.discovery_servers, !FindsLearnersAlone(role));
  }
  listener_ = std::make_unique<Listener>(&hosts_, discovery_ ? &*discovery_ : nullptr);
  auto* factory = fdds::DomainParticipantFactory::get_instance();
  participant_ = Made(
      factory->create_participant(options.domain, ParticipantQos(options, role), listener_.get(),
                                  fdds::StatusMask::none()),
      "participant in domain " + std::to_string(options.domain) + " (are its UDP ports free?)");
  if (memory_) memory_->Write();
  try {
    if (options.transport == Transport::kTcp) {
      const auto port = TcpPort(options);
      if (FindsLearnersAlone(role)) {
        workarounds::CutMuteConnections(port);
      } else {
        workarounds::EndSilentConnections(port, std::chrono::milliseconds(kLeaseMilliseconds));
        listens_on_ = port;
      }
    }
    Check(participant_->register_content_filter_factory(ActorFilterFactory::kClassName,
                                                        ActorFilterFactory::Get()),
          "registering the filter of assignments");
    fdds::PublisherQos publisher = fdds::PUBLISHER_QOS_DEFAULT;
    publisher.partition().push_back(options.run_name.c_str());
    publisher_ = Made(participant_->create_publisher(publisher), "publisher");
    fdds::SubscriberQos subscriber = fdds::SUBSCRIBER_QOS_DEFAULT;
    subscriber.partition().push_back(options.run_name.c_str());
    subscriber_ = Made(participant_->create_subscriber(subscriber), "subscriber");
  } catch (...) {
    DeleteAll();
    throw;
  }
}

Participant::~Participant() { DeleteAll(); }

void Participant::DeleteAll() {
  if (discovery_) discovery_->Stop();
  participant_->delete_contained_entities();
  if (listens_on_) workarounds::EndConnections(*listens_on_);
  fdds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
}

fdds::Topic* Participant::MakeTopic(const TopicProfile& profile, const fdds::TypeSupport& type) {
  if (fdds::TopicDescription* known = participant_->lookup_topicdescription(profile.name)) {
    return dynamic_cast<fdds::Topic*>(known);
  }
  Check(type.register_type(participant_), type.get_type_name());
  return Made(
      participant_->create_topic(profile.name, type.get_type_name(), fdds::TOPIC_QOS_DEFAULT),
      std::string("topic ") + profile.name);
}

fdds::DataWriter* Participant::MakeWriter(fdds::Topic* topic, const TopicProfile& profile,
                                          fdds::DataWriterListener* listener) {
  fdds::DataWriterQos qos = WriterQos(profile);
  if (discovery_) {
    // Peers that a server introduced do not announce themselves to each other; this makes them
    // speak often enough for their leases.
    qos.liveliness().kind = fdds::AUTOMATIC_LIVELINESS_QOS;
    qos.liveliness().lease_duration = kLease;
    qos.liveliness().announcement_period = kAnnouncement;
  }
  return Made(publisher_->create_datawriter(topic, qos, listener),
              std::string("writer of ") + profile.name);
}

fdds::DataReader* Participant::MakeReader(fdds::Topic* topic, const TopicProfile& profile,
                                          fdds::DataReaderListener* listener,
                                          std::optional<std::uint64_t> only_actor_id) {
  fdds::TopicDescription* source = topic;
  if (only_actor_id) {
    source =
        Made(participant_->create_contentfilteredtopic(
                 std::string(profile.name) + "/mine", topic, "actor_id = %0",
                 ActorFilterFactory::ParametersOf(*only_actor_id), ActorFilterFactory::kClassName),
             std::string("content filter of ") + profile.name);
  }
  return Made(subscriber_->create_datareader(source, ReaderQos(profile), listener),
              std::string("reader of ") + profile.name);
}

bool Participant::Owns(const fdds::InstanceHandle_t& endpoint) const {
  return ParticipantOf(endpoint) == ParticipantOf(participant_->get_instance_handle());
}

}  // namespace metronome::dds
