#include "hub/ingest_pipeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <type_traits>
#include <utility>
#include <variant>

#include "hub/command/control_socket.h"
#include "hub/command/order.h"
#include "hub/people_news.h"
#include "hub/receive/receive.h"
#include "hub/session/session_writer.h"
#include "hub/synchronise/synchroniser.h"
#include "shared/base/log.h"
#include "shared/wire/hub_link.h"

namespace touchline::hub {
namespace {

constexpr const char* kNeverAppeared = "its edge never appeared";

// What one camera's unit is up to, beside its report.
struct UnitState {
  bool gone = false;
  std::uint64_t frames_of_run = 0;  // since the unit appeared last
};

// The loop's state. The join timer looks at it from its own thread, under the mutex.
class Ingest {
 public:
  // `news`: null where units are told nothing of people.
  Ingest(const HubConfig& config, session::SessionWriter& writer, const IngestOptions& options,
         PeopleNews* news)
      : options_(options),
        news_(news),
        live_(config.link.mode == wire::Mode::kLive),
        writer_(writer),
        synchroniser_(ids(config), sync_options(config)) {
    for (const session::SessionCamera& camera : config.info.cameras) {
      report_.cameras.push_back({});
      report_.cameras.back().camera = camera.id;
    }
    units_.resize(report_.cameras.size());
  }

  // Every camera has ended, or gone, or never came although the time to join is over.
  bool over() const {
    for (std::size_t i = 0; i < units_.size(); ++i) {
      const bool done = report_.cameras[i].ended || units_[i].gone ||
                        (joining_over_ && !report_.cameras[i].appeared);
      if (!done) return false;
    }
    return true;
  }

  base::Status take(wire::Event event) {
    return std::visit([this](auto&& value) { return on(std::move(value)); }, std::move(event));
  }

  void end_joining() {
    joining_over_ = true;
    for (IngestCamera& camera : report_.cameras) {
      if (camera.appeared) continue;
      camera.trouble = kNeverAppeared;
      base::log_error(camera.camera.value + ": " + camera.trouble);
    }
  }

  base::Status finish() {
    for (std::size_t i = 0; i < units_.size(); ++i) {
      IngestCamera& camera = report_.cameras[i];
      // Live, the hub is stopped when the match is over: that is no trouble.
      if (live_) camera.ended = true;
      if (!camera.ended && camera.trouble.empty()) camera.trouble = "stopped before its end";
    }
    if (base::Status status = count(synchroniser_.finish()); !status) return status;
    for (const IngestCamera& camera : report_.cameras) {
      if (camera.trouble.empty()) continue;
      if (base::Status status =
              writer_.append(session::Event{last_, camera.camera, "trouble", camera.trouble});
          !status) {
        return status;
      }
    }
    return writer_.finish();
  }

  const IngestReport& report() const { return report_; }

 private:
  static std::vector<base::CameraId> ids(const HubConfig& config) {
    std::vector<base::CameraId> out;
    for (const session::SessionCamera& camera : config.info.cameras) out.push_back(camera.id);
    return out;
  }

  static synchronise::SyncOptions sync_options(const HubConfig& config) {
    synchronise::SyncOptions options;
    options.mode = config.link.mode == wire::Mode::kLive ? synchronise::SyncMode::kLive
                                                         : synchronise::SyncMode::kReplay;
    options.rate = config.info.rate;
    options.tolerance_ns = config.info.tolerance_ns;
    return options;
  }

  std::size_t index_of(const std::string& camera) const {
    const auto found =
        std::find_if(report_.cameras.begin(), report_.cameras.end(),
                     [&](const IngestCamera& c) { return c.camera.value == camera; });
    return static_cast<std::size_t>(found - report_.cameras.begin());
  }
  IngestCamera* find(const std::string& camera) {
    const std::size_t i = index_of(camera);
    return i < report_.cameras.size() ? &report_.cameras[i] : nullptr;
  }

  void refuse(const std::string& camera, const base::Error& error) {
    base::log_error(base::to_string(error));
    if (IngestCamera* entry = find(camera); entry != nullptr && entry->trouble.empty()) {
      entry->trouble = base::to_string(error);
    }
  }

  // Frame sets tell which camera missed an instant; the session keeps the views themselves.
  base::Status count(const std::vector<scene::FrameSet>& sets) {
    for (const scene::FrameSet& set : sets) {
      ++report_.instants;
      bool whole = true;
      for (const scene::FrameSetEntry& entry : set.entries) {
        const auto* absent = std::get_if<scene::Absent>(&entry.view);
        if (absent == nullptr) continue;
        whole = false;
        if (absent->reason != scene::AbsentReason::kLostInTransit &&
            absent->reason != scene::AbsentReason::kLate)
          continue;
        const session::Event lost{set.instant, entry.camera, "absent",
                                  std::string(scene::name(absent->reason))};
        if (base::Status status = writer_.append(lost); !status) return status;
      }
      if (whole) ++report_.whole_instants;
    }
    return {};
  }

  base::Status on(wire::FrameMessage message) {
    const std::string name = message.camera;
    IngestCamera* camera = find(name);
    if (camera == nullptr) return {};
    auto view = receive::to_view(std::move(message));
    if (!view) {
      refuse(name, view.error());
      return {};
    }
    last_ = std::max(last_, view->stamp.media_time);
    if (base::Status status = writer_.append(*view); !status) return status;
    ++camera->frames;
    ++units_[index_of(name)].frames_of_run;
    if (view->estimate.lost()) ++camera->frames_lost_track;
    for (const codec::EncodedPart& part : view->parts) camera->bytes += part.bytes.size();
    if (options_.progress) options_.progress(report_);
    if (news_ != nullptr) news_->see(*view);
    // The session has the parts; who was there needs none, and a camera may run far ahead of
    // another.
    view->parts.clear();
    base::Status status = count(synchroniser_.push(std::move(*view)));
    // Live, time is that of the newest frame: what is due by then goes.
    if (status && live_) status = count(synchroniser_.advance(last_));
    return status;
  }

  base::Status on(wire::PlateMessage message) {
    const std::string name = message.camera;
    IngestCamera* camera = find(name);
    if (camera == nullptr) return {};
    auto tile = receive::to_plate_tile(std::move(message));
    if (!tile) {
      refuse(name, tile.error());
      return {};
    }
    ++camera->plate_tiles;
    camera->bytes += tile->bytes.size();
    return writer_.append(*tile);
  }

  base::Status on(const wire::StatusMessage& message) {
    const auto status = receive::to_status(message);
    if (!status) {
      refuse(message.camera, status.error());
      return {};
    }
    if (status->state == receive::UnitState::kFailed) {
      if (IngestCamera* camera = find(message.camera)) camera->trouble = status->text;
      base::log_error(message.camera + ": " + status->text);
    }
    if (status->text.empty()) return {};
    return writer_.append(
        session::Event{last_, base::CameraId{message.camera}, "status", status->text});
  }

  base::Status on(const wire::EndOfStream& message) {
    IngestCamera* camera = find(message.camera);
    if (camera == nullptr) return {};
    camera->ended = true;
    const std::uint64_t arrived = units_[index_of(message.camera)].frames_of_run;
    if (!live_ && arrived != message.frames_sent && camera->trouble.empty()) {
      camera->trouble = fmt::format("{} of {} frames arrived", arrived, message.frames_sent);
      base::log_error(message.camera + ": " + camera->trouble);
    }
    return count(synchroniser_.end(camera->camera));
  }

  base::Status on(const wire::UnitAppeared& message) {
    const std::size_t i = index_of(message.camera);
    if (i >= units_.size()) return {};
    IngestCamera& camera = report_.cameras[i];
    camera.appeared = true;
    camera.ended = false;
    units_[i] = {};
    if (camera.trouble == kNeverAppeared) camera.trouble.clear();
    if (live_ && !camera.trouble.empty()) {
      // It is back; what happened stays in the session.
      const session::Event past{last_, camera.camera, "trouble", camera.trouble};
      camera.trouble.clear();
      return writer_.append(past);
    }
    return {};
  }

  base::Status on(const wire::UnitGone& message) {
    const std::size_t i = index_of(message.camera);
    if (i >= units_.size()) return {};
    units_[i].gone = true;
    if (message.finished) return {};
    report_.cameras[i].trouble =
        fmt::format("its edge vanished after {} frames{}{}", report_.cameras[i].frames,
                    message.what.empty() ? "" : ": ", message.what);
    base::log_error(message.camera + ": " + report_.cameras[i].trouble);
    return count(synchroniser_.end(report_.cameras[i].camera));
  }

  base::Status on(const wire::UnitRefused& message) {
    base::log_error(message.camera + ": a unit was refused: " + message.what);
    if (IngestCamera* camera = find(message.camera); camera != nullptr && camera->trouble.empty()) {
      camera->trouble = "a second unit was refused: " + message.what;
    }
    return {};
  }

  base::Status on(const wire::UnitOverdue& message) {
    base::log_warning(message.camera + ": its status is overdue");
    return {};
  }

  const IngestOptions& options_;
  PeopleNews* const news_;
  const bool live_;
  session::SessionWriter& writer_;
  synchronise::Synchroniser synchroniser_;
  IngestReport report_;
  std::vector<UnitState> units_;
  base::MediaTime last_;
  bool joining_over_ = false;
};

// What an operator's line came to.
std::string answer(wire::HubLink& link, const std::string& line) {
  const auto order = command::parse_order(line);
  if (!order) return "not sent: " + base::to_string(order.error());
  if (base::Status sent = link.send(*order); !sent)
    return "not sent: " + base::to_string(sent.error());
  base::log_info(order->camera + ": told: " + order->text);
  return "sent to " + order->camera;
}

}  // namespace

bool IngestReport::complete() const {
  return std::all_of(cameras.begin(), cameras.end(), [](const IngestCamera& camera) {
    return camera.ended && camera.trouble.empty();
  });
}

base::Result<IngestReport> ingest(const HubConfig& config,
                                  const std::filesystem::path& session_folder,
                                  const IngestOptions& options, std::stop_token stop) {
  if (base::Status status = config.validate(); !status) return base::fail(status.error());
  auto writer =
      session::SessionWriter::create(session_folder, config.info, {.overwrite = options.overwrite});
  if (!writer) return base::fail(writer.error());
  std::vector<base::CameraId> ids;
  for (const session::SessionCamera& camera : config.info.cameras) ids.push_back(camera.id);
  auto link = wire::HubLink::open(config.link, ids);
  if (!link) return base::fail(link.error());

  std::optional<command::ControlSocket> control;
  if (!options.control.empty()) {
    auto opened = command::ControlSocket::open(options.control);
    if (!opened) return base::fail(opened.error());
    control.emplace(std::move(*opened));
  }
  std::jthread orders([&](std::stop_token end) {
    if (control) control->serve([&](const std::string& line) { return answer(**link, line); }, end);
  });

  // A replay comes out the same each time: what units are told may not hang on who is how far.
  std::optional<PeopleNews> news;
  if (config.link.mode == wire::Mode::kLive) {
    auto pitch = pitch::make_pitch(config.info.sport, config.info.sizes);
    if (!pitch) return base::fail(pitch.error());
    news.emplace(std::move(*pitch), [&](const wire::PeopleMessage& people) {
      if (base::Status sent = (*link)->send(people); !sent)
        base::log_warning(base::to_string(sent.error()));
    });
  }

  Ingest state(config, *writer, options, news ? &*news : nullptr);
  std::mutex mutex;
  std::condition_variable_any joined;
  const bool replay = config.link.mode == wire::Mode::kReplay;
  std::jthread join_timer([&](std::stop_token end) {
    if (!replay) return;
    std::unique_lock lock(mutex);
    const auto timeout = std::chrono::duration<double>(config.join_timeout_s);
    if (joined.wait_for(lock, end, timeout, [&] { return end.stop_requested(); })) return;
    if (end.stop_requested()) return;
    state.end_joining();
    if (state.over()) (*link)->close();
  });

  base::Status trouble;
  while (auto event = (*link)->next(stop)) {
    const std::lock_guard lock(mutex);
    trouble = state.take(std::move(*event));
    if (!trouble || (replay && state.over())) break;
  }
  join_timer.request_stop();
  join_timer.join();
  if (!trouble) return base::fail(trouble.error());
  if (base::Status status = state.finish(); !status) return base::fail(status.error());
  return state.report();
}

}  // namespace touchline::hub
