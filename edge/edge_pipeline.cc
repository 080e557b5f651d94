#include "edge/edge_pipeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "edge/publish/publish.h"
#include "shared/base/bounded_queue.h"
#include "shared/base/log.h"
#include "shared/wire/edge_link.h"

namespace touchline::edge {
namespace {

constexpr std::size_t kCaptureQueue = 4;
constexpr std::size_t kPublishQueue = 64;
constexpr std::uint64_t kStatusFrames = 25;

// What the process thread hands to the publish thread.
struct Outgoing {
  ChainOutput output;
  ChainReport report;
  publish::TrackingCounts tracking;
};

// The first trouble wins; later ones are logged only.
class Trouble {
 public:
  void set(const base::Error& error) {
    base::log_error(base::to_string(error));
    const std::lock_guard lock(mutex_);
    if (!first_) first_ = error;
  }
  std::optional<base::Error> first() const {
    const std::lock_guard lock(mutex_);
    return first_;
  }

 private:
  mutable std::mutex mutex_;
  std::optional<base::Error> first_;
};

publish::UnitStatus unit_status(const EdgeConfig& config, std::uint32_t epoch,
                                const std::string& source_name, const ChainReport& report,
                                const publish::TrackingCounts& tracking, std::uint64_t sent,
                                std::uint64_t dropped) {
  publish::UnitStatus status;
  status.camera = config.camera;
  status.epoch = epoch;
  status.state = publish::UnitState::kRunning;
  status.source = source_name;
  for (const StageTime& stage : report.stages) {
    if (stage.frames == 0) continue;
    const double mean_s = stage.seconds / static_cast<double>(stage.frames);
    status.stages.push_back({stage.stage, 1 / std::max(mean_s, 1e-5), 1e3 * mean_s});
  }
  status.drops = tracking.drops;
  if (dropped > 0) status.drops["capture-queue"] = dropped;
  if (report.encode_failures > 0) status.drops["encode"] = report.encode_failures;
  status.frames_read = report.frames_in;
  status.frames_sent = sent;
  status.calibration = report.calibration;
  return status;
}

void capture_frames(capture::FrameSource& source, base::BoundedQueue<image::FramePtr>& queue,
                    std::atomic<std::uint64_t>& frames_read, Trouble& trouble,
                    std::stop_token stop) {
  while (!stop.stop_requested()) {
    auto frame = source.next(stop);
    if (!frame) {
      trouble.set(frame.error());
      break;
    }
    if (!*frame) break;
    ++frames_read;
    if (!queue.push(std::move(**frame), stop)) break;
  }
  queue.close();
}

// What the hub has asked for since the last frame.
void take_commands(wire::EdgeLink& link, FrameChain& chain) {
  while (const auto command = link.take_command()) {
    if (command->kind == wire::CommandKind::kKeyTraining) {
      chain.train_key(command->text);
    } else {
      base::log_warning("the hub sent a command that this unit has no use for: " + command->text);
    }
  }
}

// What the hub has said of people since the last frame. In a replay units are not at one frame: who
// hears what would be chance.
void take_people(wire::EdgeLink& link, bool live, FrameChain& chain) {
  while (const auto message = link.take_people()) {
    if (!live || message->domain > static_cast<std::uint8_t>(base::ClockDomain::kRecording))
      continue;
    PeopleSeen people{{message->camera},
                      {message->media_time_ns},
                      static_cast<base::ClockDomain>(message->domain),
                      {}};
    for (const wire::Place& place : message->places)
      people.places.push_back({{place.x, place.y}, place.sd_m});
    chain.hear(std::move(people));
  }
}

void process_frames(wire::EdgeLink& link, bool live, const ChainSetup& setup,
                    const ChainOptions& options, SurveyStills stills, runtime::Executor& executor,
                    head::HeadSource* head, publish::TrackingOut& tracking,
                    base::BoundedQueue<image::FramePtr>& in, base::BoundedQueue<Outgoing>& out,
                    ChainReport& report, Trouble& trouble, std::stop_token stop) {
  auto chain = FrameChain::make(setup, options, std::move(stills.frames), &executor, head);
  if (!chain) {
    trouble.set(chain.error());
    in.close();
    out.close();
    return;
  }
  chain->look_ahead(std::move(stills.take));
  // Graphics engines are served from here: the way to the hub may be slow, or wait.
  const auto hand_on = [&](ChainOutput output) {
    for (const codec::EncodedView& view : output.views) tracking.send(view);
    for (std::string& note : tracking.take_notes()) output.notes.push_back(std::move(note));
    return out.push({std::move(output), chain->report(), tracking.counts()}, stop);
  };
  while (auto frame = in.pop(stop)) {
    take_commands(link, *chain);
    take_people(link, live, *chain);
    if (!hand_on(chain->push(std::move(*frame)))) break;
  }
  take_commands(link, *chain);
  if (!stop.stop_requested()) hand_on(chain->finish());
  // What was sent stays sent whether or not the disk takes the plate.
  if (const base::Status saved = chain->save_plate(); !saved)
    base::log_warning(base::to_string(saved.error()));
  report = chain->report();
  if (report.survey_error) trouble.set(*report.survey_error);
  out.close();
}

}  // namespace

base::Result<EdgeReport> run_edge(const EdgeConfig& config, const ChainSetup& setup,
                                  const std::string& source_name, capture::FrameSource& source,
                                  SurveyStills stills, head::HeadSource* head, std::uint32_t epoch,
                                  std::stop_token stop) {
  if (base::Status status = config.validate(); !status) return base::fail(status.error());
  auto link = wire::EdgeLink::open(config.link, config.camera, epoch);
  if (!link) return base::fail(link.error());
  auto tracking = publish::TrackingOut::open(config.tracking, setup.rate);
  if (!tracking) return base::fail(tracking.error());

  const bool live = config.link.mode == wire::Mode::kLive;
  base::BoundedQueue<image::FramePtr> captured(
      kCaptureQueue, live ? base::FullPolicy::kDropOldest : base::FullPolicy::kBlock);
  base::BoundedQueue<Outgoing> outgoing(kPublishQueue, base::FullPolicy::kBlock);
  std::atomic<std::uint64_t> frames_read{0};
  Trouble trouble;
  for (const base::Error& error : stills.troubles) trouble.set(error);
  EdgeReport report;

  // Ends the threads when the caller asks for it, or when the hub cannot be served any more.
  std::stop_source end;
  const std::stop_callback forward(stop, [&] { end.request_stop(); });
  std::jthread capture_thread(
      [&] { capture_frames(source, captured, frames_read, trouble, end.get_token()); });
  std::unique_ptr<runtime::Executor> executor;
  if (live) {
    executor = std::make_unique<runtime::BackgroundExecutor>(2);
  } else {
    executor = std::make_unique<runtime::InlineExecutor>();
  }
  std::jthread process_thread([&] {
    process_frames(**link, live, setup, config.chain, std::move(stills), *executor, head, *tracking,
                   captured, outgoing, report.chain, trouble, end.get_token());
  });

  // This thread publishes.
  const auto publish_all = [&]() -> base::Status {
    const auto timeout =
        std::chrono::milliseconds(static_cast<std::int64_t>(config.hub_timeout_s * 1e3));
    if (base::Status status = (*link)->wait_for_hub(timeout, end.get_token()); !status)
      return status;
    publish::UnitStatus starting;
    starting.camera = config.camera;
    starting.epoch = epoch;
    starting.source = source_name;
    if (base::Status status = (*link)->send(publish::to_message(starting)); !status) return status;
    std::uint64_t last_status = 0;
    while (auto item = outgoing.pop(end.get_token())) {
      std::string text;
      for (const std::string& note : item->output.notes) {
        base::log_info(note);
        text += (text.empty() ? "" : "; ") + note;
      }
      for (const codec::EncodedPlateTile& tile : item->output.plates) {
        if (base::Status status = (*link)->send(publish::to_message(tile, epoch), end.get_token());
            !status) {
          return status;
        }
        report.bytes_sent += tile.bytes.size();
      }
      for (const codec::EncodedView& view : item->output.views) {
        if (base::Status status = (*link)->send(publish::to_message(view), end.get_token());
            !status)
          return status;
        ++report.frames_sent;
        for (const codec::EncodedPart& part : view.parts) report.bytes_sent += part.bytes.size();
      }
      if (!text.empty() || report.frames_sent >= last_status + kStatusFrames) {
        last_status = report.frames_sent;
        publish::UnitStatus status =
            unit_status(config, epoch, source_name, item->report, item->tracking,
                        report.frames_sent, captured.dropped());
        status.text = text;
        if (base::Status sent = (*link)->send(publish::to_message(status)); !sent) return sent;
      }
    }
    if (stop.stop_requested() && !live) {
      return base::fail(base::ErrorKind::kCancelled, config.camera.value,
                        "stopped before the source ended");
    }
    return {};
  };
  const base::Status published = publish_all();
  if (!published) end.request_stop();
  captured.close();
  capture_thread.join();
  process_thread.join();

  report.frames_read = frames_read;
  report.frames_dropped = captured.dropped();
  report.tracking = tracking->counts();
  report.trouble = trouble.first();
  if (!published) return base::fail(published.error());

  publish::UnitStatus last = unit_status(config, epoch, source_name, report.chain, report.tracking,
                                         report.frames_sent, report.frames_dropped);
  last.state = report.trouble ? publish::UnitState::kFailed : publish::UnitState::kEnded;
  if (report.trouble) last.text = base::to_string(*report.trouble);
  if (base::Status status = (*link)->send(publish::to_message(last)); !status)
    return base::fail(status.error());
  if (base::Status status = (*link)->finish(stop); !status) return base::fail(status.error());
  return report;
}

}  // namespace touchline::edge
