#include "shared/wire/edge_link.h"

#include <fmt/format.h>

#include <condition_variable>
#include <map>
#include <mutex>
#include <utility>

#include "shared/base/bounded_queue.h"
#include "shared/wire/bounds.h"
#include "shared/wire/participant_internal.h"
#include "shared/wire/samples_internal.h"

namespace touchline::wire {
namespace {

using base::ErrorKind;
using Clock = std::chrono::steady_clock;
constexpr std::size_t kMaxCommands = 64;
constexpr std::size_t kMaxPeople = 64;
constexpr unsigned kAllWriters = static_cast<unsigned>(Endpoint::kFrames) |
                                 static_cast<unsigned>(Endpoint::kPlates) |
                                 static_cast<unsigned>(Endpoint::kStatus);

// What the hub has said, and whether it is there. Written by DDS listeners, waited for by send().
class HubState {
 public:
  HubState(Mode mode, std::string camera, std::chrono::milliseconds lease)
      : mode_(mode), camera_(std::move(camera)), lease_(lease) {}

  void connection(const UnitKey& hub, Endpoint endpoint, bool connected) {
    {
      const std::lock_guard lock(mutex_);
      unsigned& endpoints = endpoints_[hub];
      const auto bit = static_cast<unsigned>(endpoint);
      endpoints = connected ? endpoints | bit : endpoints & ~bit;
      if (!connected && hub_ == hub) {
        hub_.reset();
        // A replay cannot go on with another hub: what the first had is lost with it.
        if (mode_ == Mode::kReplay && !complete_) lost_ = true;
      }
      if (endpoints == 0) endpoints_.erase(hub);
    }
    changed_.notify_all();
  }

  void command(const UnitKey& hub, const idl::Command& sample) {
    {
      const std::lock_guard lock(mutex_);
      if (sample.kind() == static_cast<std::uint8_t>(ReplyKind::kAccepted)) {
        if (!hub_ && !lost_) {
          hub_ = hub;
          credit_bytes_ = sample.credit_bytes();
        }
      } else if (sample.kind() == static_cast<std::uint8_t>(ReplyKind::kRefused)) {
        if (!hub_ || *hub_ == hub) {
          refused_ = sample.text().to_string();
          hub_.reset();
        }
      } else if (hub_ == hub) {
        if (sample.kind() == static_cast<std::uint8_t>(ReplyKind::kCredit)) {
          credit_bytes_ = std::max<std::uint64_t>(credit_bytes_, sample.credit_bytes());
        } else if (sample.kind() == static_cast<std::uint8_t>(ReplyKind::kComplete)) {
          complete_ = true;
        }
      }
    }
    changed_.notify_all();
  }

  void mismatch() {
    {
      const std::lock_guard lock(mutex_);
      mismatch_ = true;
    }
    changed_.notify_all();
  }

  base::Status wait_taken_in(std::chrono::milliseconds timeout, std::stop_token stop) {
    std::unique_lock lock(mutex_);
    const bool done = changed_.wait_until(lock, stop, Clock::now() + timeout,
                                          [&] { return taken_in() || broken().has_value(); });
    if (const auto error = broken()) return base::fail(*error);
    if (done && taken_in()) return {};
    if (stop.stop_requested()) return cancelled();
    return base::fail(
        ErrorKind::kTimeout, camera_,
        fmt::format("no hub has taken the unit in within {} ms{}", timeout.count(),
                    mismatch_ ? "; one is there with other settings (mode, status deadline)" : ""),
        "start the hub; give both the same domain and tag, and the unit the hub's address as peer");
  }

  // Replay: until `used` bytes are less than the credit.
  base::Status wait_credit(std::uint64_t used, std::stop_token stop) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, stop,
                  [&] { return broken().has_value() || !hub_ || used < credit_bytes_; });
    if (const auto error = broken()) return base::fail(*error);
    if (!hub_) return not_there();
    if (used < credit_bytes_) return {};
    return cancelled();
  }

  base::Status wait_complete(std::stop_token stop) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, stop, [&] { return broken().has_value() || complete_ || !hub_; });
    if (complete_) return {};
    if (const auto error = broken()) return base::fail(*error);
    if (!hub_) return not_there();
    return cancelled();
  }

  bool has_credit(std::uint64_t used) const {
    const std::lock_guard lock(mutex_);
    return used < credit_bytes_;
  }
  // Live: whether a hub listens. An Error when this unit was refused.
  base::Result<bool> listening() const {
    const std::lock_guard lock(mutex_);
    if (const auto error = broken()) return base::fail(*error);
    return taken_in();
  }

 private:
  bool taken_in() const {
    if (!hub_) return false;
    const auto endpoints = endpoints_.find(*hub_);
    return endpoints != endpoints_.end() && (endpoints->second & kAllWriters) == kAllWriters;
  }
  std::optional<base::Error> broken() const {
    if (refused_) {
      return base::Error{ErrorKind::kConfiguration, camera_,
                         "the hub refuses this unit: " + *refused_,
                         "give every unit its own camera id, as the hub's configuration names it"};
    }
    if (lost_) {
      return base::Error{
          ErrorKind::kUnavailable, camera_,
          fmt::format("the hub has gone (it closed, or was silent for {} ms)", lease_.count()),
          "see the hub's log, then run the whole recording again"};
    }
    return std::nullopt;
  }
  base::Status not_there() const {
    return base::fail(ErrorKind::kUnavailable, camera_, "no hub has taken the unit in",
                      "call wait_for_hub() first");
  }
  base::Status cancelled() const {
    return base::fail(ErrorKind::kCancelled, camera_, "stopped while waiting for the hub");
  }

  const Mode mode_;
  const std::string camera_;
  const std::chrono::milliseconds lease_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::map<UnitKey, unsigned> endpoints_;  // of each hub, bits of Endpoint
  std::optional<UnitKey> hub_;             // that took this unit in
  std::optional<std::string> refused_;
  std::uint64_t credit_bytes_ = 0;
  bool lost_ = false;
  bool complete_ = false;
  bool mismatch_ = false;
};

class WriterListener : public dds::DataWriterListener {
 public:
  WriterListener(HubState& hub, Endpoint endpoint) : hub_(hub), endpoint_(endpoint) {}
  void on_publication_matched(dds::DataWriter*,
                              const dds::PublicationMatchedStatus& info) override {
    if (info.current_count_change == 0) return;
    hub_.connection(unit_key(info.last_subscription_handle), endpoint_,
                    info.current_count_change > 0);
  }
  void on_offered_incompatible_qos(dds::DataWriter*,
                                   const dds::OfferedIncompatibleQosStatus&) override {
    hub_.mismatch();
  }

 private:
  HubState& hub_;
  const Endpoint endpoint_;
};

class CommandReader : public dds::DataReaderListener {
 public:
  CommandReader(HubState& hub, base::BoundedQueue<CommandMessage>& commands)
      : hub_(hub), commands_(commands) {}
  void address(const UnitKey& self) { self_ = self; }

  void on_data_available(dds::DataReader* reader) override {
    dds::SampleInfo info;
    while (reader->take_next_sample(&sample_, &info) == ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data || sample_.schema() != kSchemaVersion || sample_.unit() != self_)
        continue;
      if (sample_.kind() < kFirstCommandKind) {
        hub_.command(unit_key(info.sample_identity.writer_guid()), sample_);
      } else if (sample_.kind() <=
                 kFirstCommandKind + static_cast<std::uint8_t>(CommandKind::kConfigure)) {
        commands_.push({sample_.camera().to_string(),
                        static_cast<CommandKind>(sample_.kind() - kFirstCommandKind),
                        sample_.text().to_string()});
      }
    }
  }

 private:
  HubState& hub_;
  base::BoundedQueue<CommandMessage>& commands_;
  UnitKey self_{};
  idl::Command sample_;
};

// What other cameras see. What this unit's own camera sees would only confirm itself.
class PeopleReader : public dds::DataReaderListener {
 public:
  PeopleReader(std::string camera, base::BoundedQueue<PeopleMessage>& people)
      : camera_(std::move(camera)), people_(people) {}

  void on_data_available(dds::DataReader* reader) override {
    dds::SampleInfo info;
    while (reader->take_next_sample(&sample_, &info) == ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      auto message = from_sample(sample_);
      if (message && message->camera != camera_) people_.push(*std::move(message));
    }
  }

 private:
  const std::string camera_;
  base::BoundedQueue<PeopleMessage>& people_;
  idl::People sample_;
};

}  // namespace

struct EdgeLink::Impl {
  Impl(const LinkOptions& link_options, const base::CameraId& camera_id, std::uint32_t run)
      : options(link_options),
        camera(camera_id.value),
        epoch(run),
        commands(kMaxCommands, base::FullPolicy::kDropOldest),
        people(kMaxPeople, base::FullPolicy::kDropOldest),
        hub(options.mode, camera, options.lease),
        frame_listener(hub, Endpoint::kFrames),
        plate_listener(hub, Endpoint::kPlates),
        status_listener(hub, Endpoint::kStatus),
        command_listener(hub, commands),
        people_listener(camera, people) {}

  base::Status check(const std::string& message_camera, std::uint32_t message_epoch) const;
  // Whether to write the message now; false = there is nobody to take it.
  base::Result<bool> clear_to_send(std::stop_token stop);
  base::Status write(dds::DataWriter* writer, void* sample) const;
  base::Status write_status(const StatusMessage& message, const std::optional<EndOfStream>& end);

  const LinkOptions options;
  const std::string camera;
  const std::uint32_t epoch;
  base::BoundedQueue<CommandMessage> commands;
  base::BoundedQueue<PeopleMessage> people;
  HubState hub;
  WriterListener frame_listener;
  WriterListener plate_listener;
  WriterListener status_listener;
  CommandReader command_listener;
  PeopleReader people_listener;

  mutable std::mutex mutex;  // of report and latest
  EdgeLinkReport report;
  StatusMessage latest;
  std::uint64_t used_bytes = 0;  // of credit

  idl::Frame frame_sample;
  idl::Plate plate_sample;
  std::unique_ptr<Participant> participant;
  dds::DataWriter* frame_writer = nullptr;
  dds::DataWriter* plate_writer = nullptr;
  dds::DataWriter* status_writer = nullptr;
};

base::Status EdgeLink::Impl::check(const std::string& message_camera,
                                   std::uint32_t message_epoch) const {
  if (message_camera == camera && message_epoch == epoch) return {};
  return base::fail(ErrorKind::kInternal, camera,
                    fmt::format("a message of camera \"{}\", epoch {} was given to the link of "
                                "epoch {}",
                                message_camera, message_epoch, epoch));
}

base::Result<bool> EdgeLink::Impl::clear_to_send(std::stop_token stop) {
  if (options.mode == Mode::kLive) return hub.listening();
  const Clock::time_point start = Clock::now();
  const base::Status credit = hub.wait_credit(used_bytes, std::move(stop));
  const std::lock_guard lock(mutex);
  report.waited_s += std::chrono::duration<double>(Clock::now() - start).count();
  if (!credit) return base::fail(credit.error());
  return true;
}

base::Status EdgeLink::Impl::write(dds::DataWriter* writer, void* sample) const {
  if (writer->write(sample)) return {};
  return base::fail(ErrorKind::kUnavailable, camera,
                    fmt::format("a sample could not be sent within {} ms", options.lease.count()),
                    "is the network up, and the hub alive?");
}

base::Status EdgeLink::Impl::write_status(const StatusMessage& message,
                                          const std::optional<EndOfStream>& end) {
  idl::Status sample;
  to_sample(UnitReport{kSchemaVersion, options.mode, message, end}, sample);
  return write(status_writer, &sample);
}

EdgeLink::EdgeLink(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

EdgeLink::~EdgeLink() { impl_->participant->silence(); }

base::Result<std::unique_ptr<EdgeLink>> EdgeLink::open(const LinkOptions& options,
                                                       const base::CameraId& camera,
                                                       std::uint32_t epoch) {
  if (auto ok = options.validate(); !ok) return base::fail(ok.error());
  if (!base::is_valid(camera)) {
    return base::fail(ErrorKind::kConfiguration, "camera",
                      fmt::format("\"{}\" is no camera id", camera.value),
                      "use 1 to 32 letters, digits, '-' or '_'");
  }
  auto impl = std::make_unique<Impl>(options, camera, epoch);
  auto participant = Participant::open(options, fmt::format("touchline edge {}", camera.value));
  if (!participant) return base::fail(participant.error());
  impl->participant = *std::move(participant);
  impl->command_listener.address(impl->participant->key());
  auto commands = impl->participant->reader(TopicName::kCommand, 1, &impl->command_listener);
  if (!commands) return base::fail(commands.error());
  auto people = impl->participant->reader(TopicName::kPeople, 1, &impl->people_listener);
  if (!people) return base::fail(people.error());
  auto frames = impl->participant->writer(TopicName::kFrame, &impl->frame_listener);
  if (!frames) return base::fail(frames.error());
  auto plates = impl->participant->writer(TopicName::kPlate, &impl->plate_listener);
  if (!plates) return base::fail(plates.error());
  auto status = impl->participant->writer(TopicName::kStatus, &impl->status_listener);
  if (!status) return base::fail(status.error());
  impl->frame_writer = *frames;
  impl->plate_writer = *plates;
  impl->status_writer = *status;
  // The first status asks the hub to take this unit in; a hub that starts later gets the latest.
  impl->latest.camera = camera.value;
  impl->latest.epoch = epoch;
  if (auto ok = impl->write_status(impl->latest, std::nullopt); !ok) return base::fail(ok.error());
  return std::unique_ptr<EdgeLink>(new EdgeLink(std::move(impl)));
}

base::Status EdgeLink::wait_for_hub(std::chrono::milliseconds timeout, std::stop_token stop) {
  return impl_->hub.wait_taken_in(timeout, std::move(stop));
}

base::Status EdgeLink::send(const FrameMessage& message, std::stop_token stop) {
  if (auto ok = impl_->check(message.camera, message.epoch); !ok) return ok;
  if (auto ok = check_bounds(message); !ok) return ok;
  const base::Result<bool> clear = impl_->clear_to_send(std::move(stop));
  if (!clear) return base::fail(clear.error());
  if (!*clear) {
    const std::lock_guard lock(impl_->mutex);
    ++impl_->report.frames_alone;
    return {};
  }
  to_sample(message, impl_->frame_sample);
  if (auto ok = impl_->write(impl_->frame_writer, &impl_->frame_sample); !ok) return ok;
  impl_->used_bytes += credit_cost(message);
  const std::lock_guard lock(impl_->mutex);
  ++impl_->report.frames_sent;
  impl_->report.bytes_sent += payload_bytes(message);
  return {};
}

base::Status EdgeLink::send(const PlateMessage& message, std::stop_token stop) {
  if (auto ok = impl_->check(message.camera, message.epoch); !ok) return ok;
  if (auto ok = check_bounds(message); !ok) return ok;
  // Live: the writer keeps the newest of each tile for a hub that comes later.
  const base::Result<bool> clear = impl_->clear_to_send(std::move(stop));
  if (!clear) return base::fail(clear.error());
  to_sample(message, impl_->plate_sample);
  if (auto ok = impl_->write(impl_->plate_writer, &impl_->plate_sample); !ok) return ok;
  impl_->used_bytes += credit_cost(message);
  const std::lock_guard lock(impl_->mutex);
  ++impl_->report.plates_sent;
  impl_->report.bytes_sent += payload_bytes(message);
  return {};
}

base::Status EdgeLink::send(const StatusMessage& message) {
  if (auto ok = impl_->check(message.camera, message.epoch); !ok) return ok;
  if (auto ok = check_bounds(message); !ok) return ok;
  if (auto listening = impl_->hub.listening(); !listening) return base::fail(listening.error());
  const std::lock_guard lock(impl_->mutex);
  impl_->latest = message;
  return impl_->write_status(message, std::nullopt);
}

base::Status EdgeLink::finish(std::stop_token stop) {
  const bool live = impl_->options.mode == Mode::kLive;
  if (auto listening = impl_->hub.listening(); !listening) return base::fail(listening.error());
  if (live) {
    const auto seconds = static_cast<std::int32_t>(impl_->options.lease.count() / 1000);
    impl_->frame_writer->wait_for_acknowledgments({seconds, 0});
    impl_->plate_writer->wait_for_acknowledgments({seconds, 0});
  }
  {
    const std::lock_guard lock(impl_->mutex);
    if (impl_->latest.state != UnitState::kFailed) impl_->latest.state = UnitState::kEnded;
    impl_->latest.frames_sent = impl_->report.frames_sent;
    const EndOfStream end{impl_->camera, impl_->epoch, impl_->report.frames_sent,
                          impl_->report.plates_sent};
    if (auto ok = impl_->write_status(impl_->latest, end); !ok) return ok;
  }
  if (live) {
    impl_->status_writer->wait_for_acknowledgments({1, 0});
    return {};
  }
  return impl_->hub.wait_complete(std::move(stop));
}

std::optional<CommandMessage> EdgeLink::take_command() {
  if (impl_->commands.size() == 0) return std::nullopt;
  return impl_->commands.pop();
}

std::optional<PeopleMessage> EdgeLink::take_people() {
  if (impl_->people.size() == 0) return std::nullopt;
  return impl_->people.pop();
}

EdgeLinkReport EdgeLink::report() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->report;
}

}  // namespace touchline::wire
