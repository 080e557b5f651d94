#include <arpa/inet.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>
#include <fastdds/dds/log/Log.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>
#include <fastdds/rtps/flowcontrol/FlowControllerDescriptor.hpp>
#include <mutex>
#include <utility>

#include "shared/base/log.h"
#include "shared/wire/participant_internal.h"
#include "touchline_idl/touchlinePubSubTypes.h"

namespace touchline::wire {
namespace {

using base::ErrorKind;
using eprosima::fastrtps::Duration_t;
namespace rtps = eprosima::fastrtps::rtps;

constexpr const char* kTopicNames[kTopics] = {"edge/frame", "edge/plate", "edge/status",
                                              "hub/command", "hub/people"};
constexpr const char* kFlowController = "payload";
constexpr std::size_t kLargestSample = 64u << 20;
// Period of heartbeats, by which a reader notices a lost sample.
constexpr std::int64_t kHeartbeatMs = 50;
constexpr std::int32_t kStatusesKept = 64;  // of a unit, for a hub that is slow or joins late

constexpr std::int32_t kPeopleKept = 64;  // a message a camera

Duration_t duration(std::chrono::milliseconds time) {
  return {static_cast<std::int32_t>(time.count() / 1000),
          static_cast<std::uint32_t>(time.count() % 1000 * 1'000'000)};
}

// A generated type whose decoding answers hostile bytes with false and never throws.
template <typename Generated>
class GuardedType : public Generated {
 public:
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    if (payload->length > kLargestSample) return false;
    try {
      return Generated::deserialize(payload, data);
    } catch (const std::exception&) {
      return false;
    }
  }
};

dds::TypeSupport type_of(TopicName topic) {
  switch (topic) {
    case TopicName::kFrame:
      return dds::TypeSupport(new GuardedType<idl::FramePubSubType>());
    case TopicName::kPlate:
      return dds::TypeSupport(new GuardedType<idl::PlatePubSubType>());
    case TopicName::kStatus:
      return dds::TypeSupport(new GuardedType<idl::StatusPubSubType>());
    case TopicName::kPeople:
      return dds::TypeSupport(new GuardedType<idl::PeoplePubSubType>());
    case TopicName::kCommand:
      break;
  }
  return dds::TypeSupport(new GuardedType<idl::CommandPubSubType>());
}

// What the library has to say goes to our log, not to standard output.
class LogBridge : public dds::LogConsumer {
 public:
  void Consume(const dds::Log::Entry& entry) override {
    base::log_warning(fmt::format("dds: {}: {}", entry.context.category, entry.message));
  }
};

void bridge_log() {
  static std::once_flag once;
  std::call_once(once, [] {
    dds::Log::ClearConsumers();
    dds::Log::RegisterConsumer(std::make_unique<LogBridge>());
    dds::Log::SetVerbosity(dds::Log::Kind::Error);
  });
}

// The library would leave out an interface that is not there and be deaf without a word.
base::Status check_interfaces(const LinkOptions& options) {
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) {
    return base::fail(ErrorKind::kIo, "link.interfaces",
                      "the machine's interfaces cannot be listed");
  }
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owner(list, &freeifaddrs);
  for (const std::string& wanted : options.interfaces) {
    in_addr address{};
    inet_pton(AF_INET, wanted.c_str(), &address);
    bool there = false;
    bool running = false;
    for (const ifaddrs* each = list; each != nullptr; each = each->ifa_next) {
      if (each->ifa_addr == nullptr || each->ifa_addr->sa_family != AF_INET) continue;
      sockaddr_in own{};
      std::memcpy(&own, each->ifa_addr, sizeof(own));
      if (own.sin_addr.s_addr != address.s_addr) continue;
      there = true;
      running = running || (each->ifa_flags & IFF_RUNNING) != 0;
    }
    if (!there) {
      return base::fail(ErrorKind::kConfiguration, "link.interfaces",
                        fmt::format("{} is no address of this machine", wanted),
                        "name the address of the interface that faces the units and the hub");
    }
    if (!running) {
      return base::fail(ErrorKind::kUnavailable, "link.interfaces",
                        fmt::format("the interface of {} has no link", wanted),
                        "check the cable, and wait for the link before starting");
    }
  }
  return {};
}

dds::DomainParticipantQos participant_qos(const LinkOptions& options, const std::string& name) {
  dds::DomainParticipantQos qos;
  qos.name(name);
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList = options.interfaces;
  udp->sendBufferSize = options.socket_buffer_bytes;
  udp->receiveBufferSize = options.socket_buffer_bytes;
  udp->maxMessageSize = options.message_bytes;
  udp->maxInitialPeersRange = static_cast<std::uint32_t>(options.participants_per_peer);
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);
  qos.transport().send_socket_buffer_size = options.socket_buffer_bytes;
  qos.transport().listen_socket_buffer_size = options.socket_buffer_bytes;

  rtps::BuiltinAttributes& builtin = qos.wire_protocol().builtin;
  // The library's lease timer asserts when a participant takes its leave in the instant in which
  // the timer waits for the same lock (Fast DDS 2.9.1, PDP::check_remote_participant_liveliness). A
  // timer fires once a lease for every participant, so a long lease makes this rare, not
  // impossible.
  builtin.discovery_config.leaseDuration = duration(options.lease);
  builtin.discovery_config.leaseDuration_announcementperiod = duration(options.lease / 4);
  builtin.discovery_config.initial_announcements.count = 10;
  builtin.discovery_config.initial_announcements.period = duration(std::chrono::milliseconds(50));
  // A unicast locator without address stands for the whitelisted interfaces and keeps the default
  // multicast locators away.
  builtin.metatrafficUnicastLocatorList.push_back(rtps::Locator_t());
  for (const std::string& peer : options.peers) {
    rtps::Locator_t locator;
    locator.kind = LOCATOR_KIND_UDPv4;
    rtps::IPLocator::setIPv4(locator, peer);
    builtin.initialPeersList.push_back(locator);
  }

  if (options.mode == Mode::kLive) {
    auto flow = std::make_shared<eprosima::fastdds::rtps::FlowControllerDescriptor>();
    flow->name = kFlowController;
    flow->scheduler = eprosima::fastdds::rtps::FlowControllerSchedulerPolicy::FIFO;
    constexpr std::int64_t kPeriodMs = 10;
    flow->period_ms = kPeriodMs;
    const std::int64_t bytes = std::int64_t{options.max_mbit_s} * 125 * kPeriodMs;
    // A period must let one message through.
    flow->max_bytes_per_period =
        static_cast<std::int32_t>(std::max<std::int64_t>(bytes, options.message_bytes));
    qos.flow_controllers().push_back(flow);
  }
  return qos;
}

dds::DataWriterQos writer_qos(const LinkOptions& options, TopicName topic) {
  const bool live = options.mode == Mode::kLive;
  dds::DataWriterQos qos;
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.reliability().max_blocking_time = duration(options.lease);
  qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_ALL_HISTORY_QOS;
  qos.resource_limits().max_samples = 0;  // no bound: credit bounds it
  qos.resource_limits().max_instances = 0;
  qos.resource_limits().max_samples_per_instance = 0;
  qos.publish_mode().kind = dds::ASYNCHRONOUS_PUBLISH_MODE;
  qos.data_sharing().off();
  qos.endpoint().history_memory_policy = rtps::DYNAMIC_REUSABLE_MEMORY_MODE;
  qos.reliable_writer_qos().times.heartbeatPeriod =
      duration(std::chrono::milliseconds(kHeartbeatMs));
  qos.reliable_writer_qos().times.nackResponseDelay = duration(std::chrono::milliseconds(1));
  switch (topic) {
    case TopicName::kFrame:
      if (live) {
        qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
        qos.history().depth = options.keep_last;
        qos.lifespan().duration = duration(options.frame_lifespan);
        qos.publish_mode().flow_controller_name = kFlowController;
      }
      break;
    case TopicName::kPlate:
      if (live) {  // of each tile, the newest; a hub that joins late gets them all
        qos.durability().kind = dds::TRANSIENT_LOCAL_DURABILITY_QOS;
        qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
        qos.history().depth = 1;
        qos.publish_mode().flow_controller_name = kFlowController;
      }
      break;
    case TopicName::kStatus:
      qos.durability().kind = dds::TRANSIENT_LOCAL_DURABILITY_QOS;
      qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
      // What a status tells people must not be overtaken by the next one before it is sent.
      qos.history().depth = kStatusesKept;
      qos.deadline().period = duration(options.status_deadline);
      qos.liveliness().kind = dds::AUTOMATIC_LIVELINESS_QOS;
      qos.liveliness().lease_duration = duration(options.lease);
      qos.liveliness().announcement_period = duration(options.lease / 4);
      break;
    case TopicName::kCommand:  // keyed by unit: a dead unit holds up no other
      qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
      qos.history().depth = 64;
      break;
    case TopicName::kPeople:  // what is old is worth nothing: never sent again
      qos.reliability().kind = dds::BEST_EFFORT_RELIABILITY_QOS;
      qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
      qos.history().depth = kPeopleKept;
      break;
  }
  return qos;
}

dds::DataReaderQos reader_qos(const LinkOptions& options, TopicName topic, int units) {
  const bool live = options.mode == Mode::kLive;
  dds::DataReaderQos qos;
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_ALL_HISTORY_QOS;
  qos.resource_limits().max_samples = 0;
  qos.resource_limits().max_instances = 0;
  qos.resource_limits().max_samples_per_instance = 0;
  qos.data_sharing().off();
  qos.endpoint().history_memory_policy = rtps::DYNAMIC_REUSABLE_MEMORY_MODE;
  qos.reliable_reader_qos().times.heartbeatResponseDelay = duration(std::chrono::milliseconds(1));
  qos.reliable_reader_qos().times.initialAcknackDelay = duration(std::chrono::milliseconds(5));
  switch (topic) {
    case TopicName::kFrame:
      if (live) {
        qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
        qos.history().depth = options.keep_last * std::max(units, 1);
        qos.lifespan().duration = duration(options.frame_lifespan);
      }
      break;
    case TopicName::kPlate:
      if (live) qos.durability().kind = dds::TRANSIENT_LOCAL_DURABILITY_QOS;
      break;
    case TopicName::kStatus:
      qos.durability().kind = dds::TRANSIENT_LOCAL_DURABILITY_QOS;
      qos.deadline().period = duration(options.status_deadline);
      qos.liveliness().kind = dds::AUTOMATIC_LIVELINESS_QOS;
      qos.liveliness().lease_duration = duration(options.lease);
      break;
    case TopicName::kPeople:
      qos.reliability().kind = dds::BEST_EFFORT_RELIABILITY_QOS;
      qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
      qos.history().depth = kPeopleKept;
      break;
    case TopicName::kCommand:
      break;
  }
  return qos;
}

}  // namespace

UnitKey unit_key(const rtps::GUID_t& guid) {
  UnitKey key{};
  std::copy_n(guid.guidPrefix.value, key.size(), key.begin());
  return key;
}

UnitKey unit_key(const rtps::InstanceHandle_t& handle) {
  return unit_key(rtps::iHandle2GUID(handle));
}

base::Result<std::unique_ptr<Participant>> Participant::open(const LinkOptions& options,
                                                             const std::string& name) {
  if (auto ok = check_interfaces(options); !ok) return base::fail(ok.error());
  bridge_log();
  std::unique_ptr<Participant> self(new Participant(options));
  dds::DomainParticipantFactory* factory = dds::DomainParticipantFactory::get_instance();
  const auto refused = [&](const char* what) {
    return base::fail(ErrorKind::kIo, fmt::format("dds domain {}", options.domain), what,
                      "is the address in link.interfaces one of this machine, and are the ports of "
                      "the domain free?");
  };
  self->participant_ =
      factory->create_participant(static_cast<dds::DomainId_t>(options.domain),
                                  participant_qos(options, name), nullptr, dds::StatusMask::none());
  if (self->participant_ == nullptr) return refused("the participant could not be created");
  dds::PublisherQos publisher_qos;
  dds::SubscriberQos subscriber_qos;
  if (!options.tag.empty()) {
    publisher_qos.partition().push_back(options.tag.c_str());
    subscriber_qos.partition().push_back(options.tag.c_str());
  }
  self->publisher_ = self->participant_->create_publisher(publisher_qos);
  self->subscriber_ = self->participant_->create_subscriber(subscriber_qos);
  if (self->publisher_ == nullptr || self->subscriber_ == nullptr) {
    return refused("publisher and subscriber could not be created");
  }
  for (int i = 0; i < kTopics; ++i) {
    dds::TypeSupport type = type_of(static_cast<TopicName>(i));
    if (type.register_type(self->participant_) != ReturnCode_t::RETCODE_OK) {
      return refused("a type could not be registered");
    }
    self->topics_[i] = self->participant_->create_topic(kTopicNames[i], type.get_type_name(),
                                                        dds::TOPIC_QOS_DEFAULT);
    if (self->topics_[i] == nullptr) return refused("a topic could not be created");
  }
  return self;
}

Participant::~Participant() {
  if (participant_ == nullptr) return;
  silence();
  participant_->delete_contained_entities();
  dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
}

UnitKey Participant::key() const { return unit_key(participant_->guid()); }

base::Result<dds::DataWriter*> Participant::writer(TopicName topic,
                                                   dds::DataWriterListener* listener) {
  dds::DataWriter* writer = publisher_->create_datawriter(topics_[static_cast<int>(topic)],
                                                          writer_qos(options_, topic), listener);
  if (writer == nullptr) {
    return base::fail(ErrorKind::kInternal, kTopicNames[static_cast<int>(topic)],
                      "the writer could not be created");
  }
  writers_.push_back(writer);
  return writer;
}

base::Result<dds::DataReader*> Participant::reader(TopicName topic, int units,
                                                   dds::DataReaderListener* listener) {
  dds::DataReader* reader = subscriber_->create_datareader(
      topics_[static_cast<int>(topic)], reader_qos(options_, topic, units), listener);
  if (reader == nullptr) {
    return base::fail(ErrorKind::kInternal, kTopicNames[static_cast<int>(topic)],
                      "the reader could not be created");
  }
  readers_.push_back(reader);
  return reader;
}

void Participant::silence() {
  for (dds::DataWriter* writer : writers_) writer->set_listener(nullptr);
  for (dds::DataReader* reader : readers_) reader->set_listener(nullptr);
}

}  // namespace touchline::wire
