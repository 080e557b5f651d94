#include "shared/wire/hub_link.h"

#include <fmt/format.h>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "shared/wire/bounds.h"
#include "shared/wire/participant_internal.h"
#include "shared/wire/samples_internal.h"
#include "shared/wire/unit_table.h"

namespace touchline::wire {
namespace {

using base::ErrorKind;
constexpr std::chrono::milliseconds kTick{250};

// Takes every sample out at once and enqueues it.
template <typename Sample>
class EnqueueingReader : public dds::DataReaderListener {
 public:
  EnqueueingReader(Inbox& inbox, Endpoint endpoint) : inbox_(inbox), endpoint_(endpoint) {}

  void on_data_available(dds::DataReader* reader) override {
    dds::SampleInfo info;
    while (reader->take_next_sample(&sample_, &info) == ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      InboxItem item{unit_key(info.sample_identity.writer_guid()), Tick{}};
      if (endpoint_ == Endpoint::kStatus) remember(info, item.unit);
      if (auto message = from_sample(sample_)) {
        item.content = *std::move(message);
      } else {
        item.content = BadSample{base::to_string(message.error())};
      }
      inbox_.push(std::move(item));
    }
  }
  void on_subscription_matched(dds::DataReader*,
                               const dds::SubscriptionMatchedStatus& info) override {
    if (info.current_count_change == 0) return;
    inbox_.push({unit_key(info.last_publication_handle),
                 EndpointChange{endpoint_, info.current_count_change > 0}});
  }
  void on_liveliness_changed(dds::DataReader*,
                             const eprosima::fastdds::dds::LivelinessChangedStatus& info) override {
    if (info.not_alive_count_change <= 0) return;
    inbox_.push({unit_key(info.last_publication_handle), EndpointChange{endpoint_, false}});
  }
  void on_requested_deadline_missed(
      dds::DataReader*, const eprosima::fastrtps::RequestedDeadlineMissedStatus& info) override {
    const std::lock_guard lock(mutex_);
    const auto unit = units_.find(info.last_instance_handle);
    if (unit != units_.end()) inbox_.push({unit->second, Overdue{}});
  }

 private:
  static constexpr std::size_t kMaxInstances = 256;

  void remember(const dds::SampleInfo& info, const UnitKey& unit) {
    const std::lock_guard lock(mutex_);
    if (units_.size() < kMaxInstances || units_.contains(info.instance_handle)) {
      units_[info.instance_handle] = unit;
    }
  }

  Inbox& inbox_;
  const Endpoint endpoint_;
  Sample sample_;
  std::mutex mutex_;
  std::map<dds::InstanceHandle_t, UnitKey> units_;  // that wrote last under each status key
};

class CommandListener : public dds::DataWriterListener {
 public:
  explicit CommandListener(Inbox& inbox) : inbox_(inbox) {}
  void on_publication_matched(dds::DataWriter*,
                              const dds::PublicationMatchedStatus& info) override {
    if (info.current_count_change == 0) return;
    inbox_.push({unit_key(info.last_subscription_handle),
                 EndpointChange{Endpoint::kCommands, info.current_count_change > 0}});
  }

 private:
  Inbox& inbox_;
};

}  // namespace

struct HubLink::Impl {
  Impl(const LinkOptions& link_options, std::span<const base::CameraId> cameras)
      : options(link_options),
        inbox(options.mode, options.keep_last, options.credit_bytes + kMaxFrameBytes),
        frames(inbox, Endpoint::kFrames),
        plates(inbox, Endpoint::kPlates),
        statuses(inbox, Endpoint::kStatus),
        commands(inbox),
        table(options, cameras) {}

  base::Status write(idl::Command sample);
  void handle(UnitTable::Outcome outcome);

  const LinkOptions options;
  Inbox inbox;
  EnqueueingReader<idl::Frame> frames;
  EnqueueingReader<idl::Plate> plates;
  EnqueueingReader<idl::Status> statuses;
  CommandListener commands;

  mutable std::mutex mutex;  // of table, events, report, and of the order of commands
  UnitTable table;
  std::deque<Event> events;
  HubLinkReport report;

  std::unique_ptr<Participant> participant;
  dds::DataWriter* command_writer = nullptr;
  dds::DataWriter* people_writer = nullptr;
  std::jthread ticker;
};

base::Status HubLink::Impl::write(idl::Command sample) {
  if (!command_writer->write(&sample)) {
    return base::fail(ErrorKind::kUnavailable, sample.camera().to_string(),
                      "the command could not be sent");
  }
  return {};
}

void HubLink::Impl::handle(UnitTable::Outcome outcome) {
  for (const Reply& reply : outcome.replies) (void)write(to_sample(reply));
  for (Event& event : outcome.events) events.push_back(std::move(event));
  for (const UnitKey& unit : outcome.forgotten) inbox.forget(unit);
}

HubLink::HubLink(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

HubLink::~HubLink() {
  close();
  // What the units wait for last is that their streams are complete: let it arrive.
  impl_->command_writer->wait_for_acknowledgments({1, 0});
  impl_->participant->silence();
}

base::Result<std::unique_ptr<HubLink>> HubLink::open(const LinkOptions& options,
                                                     std::span<const base::CameraId> cameras) {
  if (auto ok = options.validate(); !ok) return base::fail(ok.error());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (!base::is_valid(cameras[i])) {
      return base::fail(ErrorKind::kConfiguration, "cameras",
                        fmt::format("\"{}\" is no camera id", cameras[i].value));
    }
    for (std::size_t j = 0; j < i; ++j) {
      if (cameras[j] == cameras[i]) {
        return base::fail(ErrorKind::kConfiguration, "cameras",
                          fmt::format("camera \"{}\" is named twice", cameras[i].value));
      }
    }
  }
  auto impl = std::make_unique<Impl>(options, cameras);
  auto participant = Participant::open(options, "touchline hub");
  if (!participant) return base::fail(participant.error());
  impl->participant = *std::move(participant);
  auto writer = impl->participant->writer(TopicName::kCommand, &impl->commands);
  if (!writer) return base::fail(writer.error());
  impl->command_writer = *writer;
  auto people = impl->participant->writer(TopicName::kPeople, nullptr);
  if (!people) return base::fail(people.error());
  impl->people_writer = *people;
  const int units = static_cast<int>(cameras.size());
  for (const auto& [topic, listener] :
       {std::pair<TopicName, dds::DataReaderListener*>{TopicName::kFrame, &impl->frames},
        {TopicName::kPlate, &impl->plates},
        {TopicName::kStatus, &impl->statuses}}) {
    if (auto reader = impl->participant->reader(topic, units, listener); !reader) {
      return base::fail(reader.error());
    }
  }
  impl->ticker = std::jthread([&inbox = impl->inbox](std::stop_token stop) {
    std::mutex mutex;
    std::condition_variable_any never;
    std::unique_lock lock(mutex);
    while (!stop.stop_requested()) {
      never.wait_for(lock, stop, kTick, [] { return false; });
      inbox.push({UnitKey{}, Tick{}});
    }
  });
  return std::unique_ptr<HubLink>(new HubLink(std::move(impl)));
}

std::optional<Event> HubLink::next(std::stop_token stop) {
  while (true) {
    {
      const std::lock_guard lock(impl_->mutex);
      if (!impl_->events.empty()) {
        Event event = std::move(impl_->events.front());
        impl_->events.pop_front();
        if (const auto* frame = std::get_if<FrameMessage>(&event)) {
          ++impl_->report.frames;
          impl_->report.bytes += payload_bytes(*frame);
        } else if (const auto* plate = std::get_if<PlateMessage>(&event)) {
          ++impl_->report.plates;
          impl_->report.bytes += payload_bytes(*plate);
        }
        return event;
      }
    }
    std::optional<InboxItem> item = impl_->inbox.pop(stop);
    if (!item) return std::nullopt;
    const std::lock_guard lock(impl_->mutex);
    impl_->handle(impl_->table.process(*std::move(item), std::chrono::steady_clock::now()));
  }
}

base::Status HubLink::send(const CommandMessage& command) {
  if (auto ok = check_bounds(command); !ok) return ok;
  const std::lock_guard lock(impl_->mutex);
  std::vector<Reply> addresses;
  if (command.camera.empty()) {
    addresses = impl_->table.everyone();
  } else if (auto address = impl_->table.address(command.camera)) {
    addresses.push_back(*std::move(address));
  }
  if (addresses.empty()) {
    return base::fail(ErrorKind::kNotFound, command.camera.empty() ? "units" : command.camera,
                      "no unit is there to take the command");
  }
  for (const Reply& address : addresses) {
    if (auto ok = impl_->write(to_sample(address, command)); !ok) return ok;
  }
  return {};
}

base::Status HubLink::send(const PeopleMessage& people) {
  if (auto ok = check_bounds(people); !ok) return ok;
  idl::People sample;
  to_sample(people, sample);
  if (impl_->people_writer->write(&sample)) return {};
  return base::fail(ErrorKind::kUnavailable, people.camera, "its people could not be sent");
}

void HubLink::pause(const base::CameraId& camera, bool paused) {
  const std::lock_guard lock(impl_->mutex);
  impl_->handle(impl_->table.pause(camera.value, paused));
}

void HubLink::close() {
  impl_->ticker.request_stop();
  impl_->inbox.close();
}

HubLinkReport HubLink::report() const {
  const std::lock_guard lock(impl_->mutex);
  HubLinkReport report = impl_->report;
  report.frames_dropped = impl_->inbox.dropped();
  report.samples_refused = impl_->inbox.refused() + impl_->table.refused();
  return report;
}

}  // namespace touchline::wire
