// A DDS participant with the transport and QoS profiles of the wire, and its topics.
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
#include <string>

#include "shared/base/result.h"
#include "shared/wire/inbox.h"
#include "shared/wire/link_options.h"

namespace touchline::wire {

namespace dds = eprosima::fastdds::dds;

enum class TopicName : std::uint8_t { kFrame, kPlate, kStatus, kCommand, kPeople };
inline constexpr int kTopics = 5;

UnitKey unit_key(const eprosima::fastrtps::rtps::GUID_t& guid);
UnitKey unit_key(const eprosima::fastrtps::rtps::InstanceHandle_t& handle);

class Participant {
 public:
  // `name` is shown by DDS tools.
  static base::Result<std::unique_ptr<Participant>> open(const LinkOptions& options,
                                                         const std::string& name);
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  UnitKey key() const;
  // The listener must outlive this object or be taken off by silence(). `units`: how many writers a
  // reader is to keep samples of.
  base::Result<dds::DataWriter*> writer(TopicName topic, dds::DataWriterListener* listener);
  base::Result<dds::DataReader*> reader(TopicName topic, int units,
                                        dds::DataReaderListener* listener);
  // No listener is called after this.
  void silence();

 private:
  explicit Participant(const LinkOptions& options) : options_(options) {}

  const LinkOptions options_;
  dds::DomainParticipant* participant_ = nullptr;
  dds::Publisher* publisher_ = nullptr;
  dds::Subscriber* subscriber_ = nullptr;
  dds::Topic* topics_[kTopics] = {};
  std::vector<dds::DataWriter*> writers_;
  std::vector<dds::DataReader*> readers_;
};

}  // namespace touchline::wire
