#include "hub/people_news.h"

#include <algorithm>
#include <utility>

#include "hub/track/standing.h"
#include "shared/codec/view_codec.h"

namespace touchline::hub {
namespace {

constexpr std::int64_t kPeriodNs = 200'000'000;  // between two news of one camera
constexpr std::size_t kWaiting = 16;             // views; older ones give way
constexpr double kLeastSd = 0.1;                 // metres: nobody stands on a point

}  // namespace

PeopleNews::PeopleNews(pitch::PitchModel pitch,
                       std::function<void(const wire::PeopleMessage&)> send)
    : pitch_(std::move(pitch)),
      send_(std::move(send)),
      queue_(kWaiting, base::FullPolicy::kDropOldest),
      thread_([this](std::stop_token stop) {
        while (const auto view = queue_.pop(stop)) tell(*view);
      }) {}

PeopleNews::~PeopleNews() { queue_.close(); }

void PeopleNews::see(const codec::EncodedView& view) {
  const std::string& name = view.id.camera.value;
  Camera& camera = cameras_[name];
  camera.lost = view.estimate.lost();
  // People found by people would go round in circles.
  if (camera.lost || view.estimate.evidence == geometry::Evidence::kPeers) return;
  const bool wanted = std::any_of(cameras_.begin(), cameras_.end(), [&](const auto& other) {
    return other.first != name && other.second.lost;
  });
  const std::int64_t now = view.stamp.media_time.ns;
  if (!wanted || view.find(codec::PartKind::kMatte) == nullptr) return;
  if (camera.told && now >= camera.told_ns && now - camera.told_ns < kPeriodNs) return;
  camera.told = true;
  camera.told_ns = now;
  queue_.push(view);
}

void PeopleNews::tell(const codec::EncodedView& view) const {
  const auto decoded = codec::decode(view);
  if (!decoded) return;
  wire::PeopleMessage message;
  message.camera = view.id.camera.value;
  message.media_time_ns = view.stamp.media_time.ns;
  message.domain = static_cast<std::uint8_t>(view.stamp.domain);
  for (const track::Standing& one : track::standing(*decoded, pitch_)) {
    if (message.places.size() == wire::kMaxPlaces) break;
    message.places.push_back({static_cast<float>(one.at.x()), static_cast<float>(one.at.y()),
                              static_cast<float>(std::max(one.sd_m, kLeastSd))});
  }
  if (!message.places.empty()) send_(message);
}

}  // namespace touchline::hub
