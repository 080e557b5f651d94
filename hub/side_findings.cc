#include "hub/side_findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "shared/recording/recording.h"

namespace touchline::hub {
namespace {

recording::Side opposite(recording::Side side) {
  switch (side) {
    case recording::Side::kMain:
      return recording::Side::kReverse;
    case recording::Side::kReverse:
      return recording::Side::kMain;
    case recording::Side::kLeft:
      return recording::Side::kRight;
    case recording::Side::kRight:
      return recording::Side::kLeft;
  }
  return side;
}

std::string listed(const std::vector<base::CameraId>& cameras) {
  std::string out;
  for (const base::CameraId& camera : cameras) out += (out.empty() ? "" : ", ") + camera.value;
  return out;
}

std::string cure(const session::SessionInfo& info, const base::CameraId& camera) {
  for (const session::SessionCamera& stated : info.cameras) {
    if (stated.id != camera) continue;
    return fmt::format("side = \"{}\" is stated; state side = \"{}\"", recording::name(stated.side),
                       recording::name(opposite(stated.side)));
  }
  return "state the other side";
}

}  // namespace

base::Result<SideFindings> check_sides(Shot& shot, int most_instants) {
  SideFindings out;
  track::SideCheck check(shot.pitch());
  const std::vector<std::int64_t>& frames = shot.frames();
  const std::size_t most =
      std::min(frames.size(), static_cast<std::size_t>(std::clamp(most_instants, 1, 1000)));
  for (std::size_t i = 0; i < most; ++i) {
    const std::size_t at = most == 1 ? 0 : i * (frames.size() - 1) / (most - 1);
    const auto set = shot.decode(frames[at]);
    if (!set) return base::fail(set.error());
    check.add(set->views);
    ++out.instants;
  }
  out.report = check.report();
  const session::SessionInfo& info = shot.session().info();
  for (const track::TurnedCameras& found : out.report.turned) {
    for (const base::CameraId& camera : found.cameras) {
      std::string text;
      if (found.undecided) {
        text = fmt::format(
            "agrees about people with half of {} only when turned by 180 degrees ({} places): one "
            "half stands on the other side. If it is this one: {}",
            listed(found.cameras), found.places, cure(info, camera));
      } else {
        text = fmt::format(
            "agrees with the other cameras about people only when turned by 180 degrees ({} "
            "places): it stands on the other side; {}",
            found.places, cure(info, camera));
      }
      out.troubles.push_back({camera, std::move(text)});
    }
  }
  return out;
}

}  // namespace touchline::hub
