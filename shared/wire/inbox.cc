#include "shared/wire/inbox.h"

#include <utility>

#include "shared/wire/bounds.h"

namespace touchline::wire {
namespace {

std::size_t cost_of(const InboxItem& item) {
  if (const auto* frame = std::get_if<FrameMessage>(&item.content)) return credit_cost(*frame);
  if (const auto* plate = std::get_if<PlateMessage>(&item.content)) return credit_cost(*plate);
  return kMessageCost;
}

}  // namespace

Inbox::Inbox(Mode mode, int keep_last, std::size_t max_unit_bytes)
    : mode_(mode),
      keep_last_(static_cast<std::size_t>(keep_last)),
      max_unit_bytes_(max_unit_bytes),
      order_(kMaxItems, base::FullPolicy::kBlock) {}

bool Inbox::push(InboxItem item) {
  const std::lock_guard lock(mutex_);
  // The queue never fills: connections are told apart by unit, and a unit is bounded below.
  if (order_.size() + 1 >= kMaxItems) {
    ++refused_;
    return false;
  }
  if (std::holds_alternative<Tick>(item.content)) return order_.push({std::move(item), false, 0});
  auto found = lanes_.find(item.unit);
  if (found == lanes_.end()) {
    if (lanes_.size() >= kMaxUnits) {
      ++refused_;
      return false;
    }
    found = lanes_.emplace(item.unit, std::make_unique<Lane>(keep_last_)).first;
  }
  Lane& lane = *found->second;
  if (mode_ == Mode::kLive && std::holds_alternative<FrameMessage>(item.content)) {
    const std::uint64_t before = lane.frames.dropped();
    lane.frames.push(std::get<FrameMessage>(std::move(item.content)));
    // The ticket of the frame that was dropped serves for this one.
    if (lane.frames.dropped() != before) return true;
    return order_.push({InboxItem{item.unit, Tick{}}, true, 0});
  }
  // A change of connection is never refused: losing one would leave a unit half known.
  const bool connection = std::holds_alternative<EndpointChange>(item.content);
  const std::size_t cost = connection ? 0 : cost_of(item);
  if (cost > 0 && lane.bytes + cost > max_unit_bytes_) {
    ++refused_;
    return false;
  }
  lane.bytes += cost;
  return order_.push({std::move(item), false, cost});
}

std::optional<InboxItem> Inbox::pop(std::stop_token stop) {
  std::optional<Ticket> ticket = order_.pop(std::move(stop));
  if (!ticket) return std::nullopt;
  if (ticket->cost > 0 || ticket->next_of_lane) {
    const std::lock_guard lock(mutex_);
    Lane& lane = *lanes_.at(ticket->item.unit);
    lane.bytes -= ticket->cost;
    if (ticket->next_of_lane) ticket->item.content = *lane.frames.pop();
  }
  return std::move(ticket->item);
}

void Inbox::forget(const UnitKey& unit) {
  const std::lock_guard lock(mutex_);
  const auto found = lanes_.find(unit);
  if (found == lanes_.end() || found->second->bytes > 0 || found->second->frames.size() > 0) return;
  dropped_before_ += found->second->frames.dropped();
  lanes_.erase(found);
}

void Inbox::close() { order_.close(); }

std::uint64_t Inbox::dropped() const {
  const std::lock_guard lock(mutex_);
  std::uint64_t dropped = dropped_before_;
  for (const auto& [unit, lane] : lanes_) dropped += lane->frames.dropped();
  return dropped;
}

std::uint64_t Inbox::refused() const {
  const std::lock_guard lock(mutex_);
  return refused_;
}

}  // namespace touchline::wire
