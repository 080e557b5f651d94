#include "shared/wire/unit_table.h"

#include <fmt/format.h>

#include <utility>

#include "shared/wire/bounds.h"

namespace touchline::wire {
namespace {

constexpr unsigned kAllEndpoints = 15;
constexpr std::size_t kMaxHeldBytes = 256u << 20;
// Beyond the lease: how long a newcomer waits for the first unit to show itself.
constexpr std::chrono::milliseconds kGrace{1000};

std::string mode_name(Mode mode) { return mode == Mode::kLive ? "live" : "replay"; }

}  // namespace

UnitTable::UnitTable(const LinkOptions& options, std::span<const base::CameraId> cameras)
    : options_(options) {
  for (const base::CameraId& camera : cameras) cameras_.insert(camera.value);
}

UnitTable::Outcome UnitTable::process(InboxItem item, Time now) {
  Outcome out;
  const UnitKey key = item.unit;
  if (auto* message = std::get_if<FrameMessage>(&item.content)) {
    frame(key, std::move(*message), out);
  } else if (auto* tile = std::get_if<PlateMessage>(&item.content)) {
    plate(key, std::move(*tile), out);
  } else if (auto* status = std::get_if<UnitReport>(&item.content)) {
    report(key, std::move(*status), now, out);
  } else if (const auto* change = std::get_if<EndpointChange>(&item.content)) {
    connection(key, *change, now, out);
  } else if (std::holds_alternative<Tick>(item.content)) {
    tick(now, out);
  } else if (std::holds_alternative<Overdue>(item.content)) {
    const auto unit = units_.find(key);
    if (options_.mode == Mode::kLive && unit != units_.end() &&
        unit->second.state == State::kTaken && !unit->second.finished) {
      out.events.emplace_back(UnitOverdue{unit->second.camera});
    }
  } else if (auto* bad = std::get_if<BadSample>(&item.content)) {
    ++refused_;
    const auto unit = units_.find(key);
    if (unit != units_.end() && unit->second.state != State::kRefused) {
      refuse(key, unit->second, std::move(bad->what), out);
    }
  }
  return out;
}

void UnitTable::connection(const UnitKey& key, EndpointChange change, Time now, Outcome& out) {
  Unit& unit = units_[key];
  const auto bit = static_cast<unsigned>(change.endpoint);
  if (change.connected) {
    unit.endpoints |= bit;
    consider(key, unit, now, out);
    return;
  }
  unit.endpoints &= ~bit;
  leave(key, unit, now, out);
  if (unit.endpoints == 0) {
    units_.erase(key);
    out.forgotten.push_back(key);
  }
}

void UnitTable::report(const UnitKey& key, UnitReport report, Time now, Outcome& out) {
  Unit& unit = units_[key];
  if (unit.state == State::kArriving) {
    unit.hello = std::move(report);
    consider(key, unit, now, out);
    return;
  }
  if (unit.state != State::kTaken || report.status.camera != unit.camera ||
      report.status.epoch != unit.epoch) {
    stray(key, unit, out);
    return;
  }
  sign_of_life(key, out);
  const std::optional<EndOfStream> end = report.end;
  out.events.emplace_back(std::move(report.status));
  if (end && !unit.end) {
    unit.end = end;
    complete_if_all_here(key, unit, out);
  }
}

void UnitTable::consider(const UnitKey& key, Unit& unit, Time now, Outcome& out) {
  if (unit.state != State::kArriving || !unit.hello) return;
  const auto commands = static_cast<unsigned>(Endpoint::kCommands);
  if ((unit.endpoints & commands) == 0) return;  // it could not hear an answer
  const UnitReport& hello = *unit.hello;
  const std::string& camera = hello.status.camera;
  unit.camera = camera;
  unit.epoch = hello.status.epoch;
  if (hello.schema != kSchemaVersion) {
    refuse(key, unit,
           fmt::format("the unit speaks schema {} and the hub schema {}: update the older one",
                       hello.schema, kSchemaVersion),
           out);
  } else if (!cameras_.contains(camera)) {
    refuse(key, unit, fmt::format("camera \"{}\" is not configured at the hub", camera), out);
  } else if (hello.mode != options_.mode) {
    refuse(key, unit,
           fmt::format("camera \"{}\": the unit is in {} mode and the hub in {} mode", camera,
                       mode_name(hello.mode), mode_name(options_.mode)),
           out);
  } else if (lost_.contains(key)) {
    refuse(key, unit, silence_text(camera), out);
  } else if (holders_.contains(camera)) {
    if (!unit.waiting_since) unit.waiting_since = now;
  } else if (unit.endpoints == kAllEndpoints) {
    take_in(key, unit, out);
  }
}

void UnitTable::take_in(const UnitKey& key, Unit& unit, Outcome& out) {
  unit.state = State::kTaken;
  unit.waiting_since.reset();
  holders_[unit.camera] = key;
  out.events.emplace_back(UnitAppeared{unit.camera, unit.epoch});
  unit.granted_bytes = options_.credit_bytes;
  out.replies.push_back(
      {key, ReplyKind::kAccepted, unit.camera, unit.epoch, unit.granted_bytes, {}});
  UnitReport hello = std::move(*unit.hello);
  unit.hello.reset();
  std::vector<PlateMessage> held = std::move(unit.held);
  unit.held.clear();
  out.events.emplace_back(std::move(hello.status));
  for (PlateMessage& message : held) plate(key, std::move(message), out);
  if (hello.end) {
    unit.end = hello.end;
    complete_if_all_here(key, unit, out);
  }
}

void UnitTable::refuse(const UnitKey& key, Unit& unit, std::string why, Outcome& out) {
  const bool had_camera = unit.state == State::kTaken;
  if (unit.state != State::kGone) {
    out.events.emplace_back(UnitRefused{unit.camera, unit.epoch, why});
  }
  out.replies.push_back({key, ReplyKind::kRefused, unit.camera, unit.epoch, 0, std::move(why)});
  unit.state = State::kRefused;
  unit.held.clear();
  if (had_camera) {
    holders_.erase(unit.camera);
    out.events.emplace_back(
        UnitGone{unit.camera, unit.epoch, unit.finished, unit.frames, "it was refused"});
  }
}

// A sample of a unit that should not send.
void UnitTable::stray(const UnitKey& key, Unit& unit, Outcome& out) {
  ++refused_;
  if (unit.state == State::kGone) refuse(key, unit, silence_text(unit.camera), out);
}

std::string UnitTable::silence_text(const std::string& camera) const {
  return fmt::format(
      "camera \"{}\": nothing was heard of the unit for {} ms, and the hub has gone on without it",
      camera, options_.lease.count());
}

// The unit that has a camera lives: whoever waits for that camera is a duplicate.
void UnitTable::sign_of_life(const UnitKey& key, Outcome& out) {
  const std::string& camera = units_.at(key).camera;
  for (auto& [other_key, other] : units_) {
    if (other.waiting_since && other.camera == camera) {
      other.waiting_since.reset();
      refuse(other_key, other,
             fmt::format("camera \"{}\" is taken: another unit with this id is running", camera),
             out);
    }
  }
}

void UnitTable::tick(Time now, Outcome& out) {
  for (auto& [key, unit] : units_) {
    if (unit.waiting_since && now - *unit.waiting_since > options_.lease + kGrace) {
      const auto holder = holders_.find(unit.camera);
      if (holder != holders_.end()) {
        sign_of_life(holder->second, out);
        return;
      }
    }
  }
}

void UnitTable::frame(const UnitKey& key, FrameMessage message, Outcome& out) {
  Unit& unit = units_[key];
  if (unit.state != State::kTaken || message.camera != unit.camera || message.epoch != unit.epoch ||
      unit.finished) {
    stray(key, unit, out);
    return;
  }
  sign_of_life(key, out);
  ++unit.frames;
  unit.used_bytes += credit_cost(message);
  out.events.emplace_back(std::move(message));
  grant(key, unit, false, out);
  complete_if_all_here(key, unit, out);
}

void UnitTable::plate(const UnitKey& key, PlateMessage message, Outcome& out) {
  Unit& unit = units_[key];
  if (unit.state == State::kArriving) {
    if (unit.held_bytes + message.bytes.size() > kMaxHeldBytes) {
      ++refused_;
      return;
    }
    unit.held_bytes += message.bytes.size();
    unit.held.push_back(std::move(message));
    return;
  }
  if (unit.state != State::kTaken || message.camera != unit.camera || message.epoch != unit.epoch ||
      unit.finished) {
    stray(key, unit, out);
    return;
  }
  ++unit.plates;
  unit.used_bytes += credit_cost(message);
  out.events.emplace_back(std::move(message));
  grant(key, unit, false, out);
  complete_if_all_here(key, unit, out);
}

void UnitTable::grant(const UnitKey& key, Unit& unit, bool always, Outcome& out) {
  if (options_.mode != Mode::kReplay || paused_.contains(unit.camera)) return;
  const std::uint64_t grant = unit.used_bytes + options_.credit_bytes;
  // A reply for each quarter of the credit keeps the unit going without a reply a frame.
  if (grant == unit.granted_bytes ||
      (!always && grant - unit.granted_bytes < options_.credit_bytes / 4)) {
    return;
  }
  unit.granted_bytes = grant;
  out.replies.push_back({key, ReplyKind::kCredit, unit.camera, unit.epoch, grant, {}});
}

void UnitTable::complete_if_all_here(const UnitKey& key, Unit& unit, Outcome& out) {
  if (unit.finished || !unit.end) return;
  // Live drops frames on purpose; what is still on the way then comes after the end and is stray.
  if (options_.mode == Mode::kReplay &&
      (unit.frames < unit.end->frames_sent || unit.plates < unit.end->plates_sent)) {
    return;
  }
  unit.finished = true;
  out.events.emplace_back(*unit.end);
  out.replies.push_back({key, ReplyKind::kComplete, unit.camera, unit.epoch, 0, {}});
}

void UnitTable::leave(const UnitKey& key, Unit& unit, Time now, Outcome& out) {
  if (unit.state == State::kArriving) {
    unit.waiting_since.reset();
    return;
  }
  if (unit.state != State::kTaken) return;
  unit.state = State::kGone;
  holders_.erase(unit.camera);
  if (options_.mode == Mode::kReplay && !unit.finished) lost_.insert(key);
  std::string what;
  if (unit.finished) {
    what = fmt::format("camera \"{}\": the unit has ended", unit.camera);
  } else if (unit.end) {
    what = fmt::format("camera \"{}\": the unit left after {} of {} frames had arrived",
                       unit.camera, unit.frames, unit.end->frames_sent);
  } else {
    what = fmt::format(
        "camera \"{}\": the unit has gone without an end of stream; {} frames had arrived",
        unit.camera, unit.frames);
  }
  out.events.emplace_back(
      UnitGone{unit.camera, unit.epoch, unit.finished, unit.frames, std::move(what)});
  for (auto& [other_key, other] : units_) {
    if (other.waiting_since && other.camera == unit.camera && other_key != key) {
      other.waiting_since.reset();
      consider(other_key, other, now, out);
      if (other.state == State::kTaken) break;
    }
  }
}

UnitTable::Outcome UnitTable::pause(const std::string& camera, bool paused) {
  Outcome out;
  if (paused) {
    paused_.insert(camera);
    return out;
  }
  if (paused_.erase(camera) == 0) return out;
  const auto holder = holders_.find(camera);
  if (holder != holders_.end()) grant(holder->second, units_.at(holder->second), true, out);
  return out;
}

std::optional<Reply> UnitTable::address(const std::string& camera) const {
  const auto holder = holders_.find(camera);
  if (holder == holders_.end()) return std::nullopt;
  return Reply{
      holder->second, ReplyKind::kAccepted, camera, units_.at(holder->second).epoch, 0, {}};
}

std::vector<Reply> UnitTable::everyone() const {
  std::vector<Reply> addresses;
  for (const auto& [camera, key] : holders_) addresses.push_back(*address(camera));
  return addresses;
}

}  // namespace touchline::wire
