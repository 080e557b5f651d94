#include "hub/render/stadium.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "shared/base/bounds.h"

namespace touchline::render {
namespace {

// Axes of a side: outward unit vector and where the line lies along it.
struct SideAxes {
  int across;   // 0 = x, 1 = y: the axis that points outward
  double sign;  // of outward along it
  double line;  // distance of the line from the centre
};

SideAxes axes(const Stadium& stadium, PitchSide side) {
  switch (side) {
    case PitchSide::kNear:
      return {1, -1, stadium.half_width_m};
    case PitchSide::kFar:
      return {1, 1, stadium.half_width_m};
    case PitchSide::kLeft:
      return {0, -1, stadium.half_length_m};
    case PitchSide::kRight:
      return {0, 1, stadium.half_length_m};
  }
  return {1, -1, stadium.half_width_m};
}

// Outward distance of a profile at a height; held beyond its ends.
double outward_at(const std::vector<ProfilePoint>& profile, double height) {
  if (profile.empty()) return 1e9;
  if (height <= profile.front().height_m) return profile.front().outward_m;
  for (std::size_t i = 1; i < profile.size(); ++i) {
    const ProfilePoint& a = profile[i - 1];
    const ProfilePoint& b = profile[i];
    if (height > b.height_m) continue;
    const double rise = b.height_m - a.height_m;
    const double s = rise > 1e-9 ? (height - a.height_m) / rise : 1;
    return a.outward_m + s * (b.outward_m - a.outward_m);
  }
  return profile.back().outward_m;
}

}  // namespace

std::string_view name(PitchSide side) {
  switch (side) {
    case PitchSide::kNear:
      return "near";
    case PitchSide::kFar:
      return "far";
    case PitchSide::kLeft:
      return "left";
    case PitchSide::kRight:
      return "right";
  }
  return "?";
}

base::Status StadiumOptions::validate() const {
  for (const base::Status& status :
       {base::in_bounds("stadium.margin_m", margin_m, 1, 50),
        base::in_bounds("stadium.hoarding_m", hoarding_m, 0.2, 5),
        base::in_bounds("stadium.stand_slope_deg", stand_slope_deg, 5, 89),
        base::in_bounds("stadium.top_m", top_m, 5, 100),
        base::in_bounds("stadium.least_margin_m", least_margin_m, 0.5, 20),
        base::in_bounds("stadium.most_margin_m", most_margin_m, least_margin_m, 60),
        base::in_bounds("stadium.least_agreement", least_agreement, 0, 1)}) {
    if (!status) return status;
  }
  return {};
}

Stadium default_stadium(const pitch::PitchModel& pitch, const StadiumOptions& options) {
  Stadium stadium;
  stadium.half_length_m = pitch.length_m / 2 + pitch.in_goal_m;
  stadium.half_width_m = pitch.width_m / 2;
  const double slope = std::tan(options.stand_slope_deg * std::numbers::pi / 180);
  for (StadiumSide& side : stadium.sides) {
    const double foot = -pitch.crown_m - 0.5;  // below the turf, so that no ray slips under it
    side.profile = {
        {options.margin_m, foot},
        {options.margin_m, options.hoarding_m},
        {options.margin_m + (options.top_m - options.hoarding_m) / slope, options.top_m}};
  }
  return stadium;
}

std::optional<StadiumHit> intersect(const Stadium& stadium, const Eigen::Vector3d& origin,
                                    const Eigen::Vector3d& direction) {
  std::optional<StadiumHit> best;
  for (const PitchSide side :
       {PitchSide::kNear, PitchSide::kFar, PitchSide::kLeft, PitchSide::kRight}) {
    const SideAxes a = axes(stadium, side);
    const double out0 = a.sign * origin[a.across] - a.line;  // outward of the origin
    const double out_d = a.sign * direction[a.across];
    const std::vector<ProfilePoint>& profile = stadium.side(side).profile;
    for (std::size_t i = 1; i < profile.size(); ++i) {
      const ProfilePoint& p = profile[i - 1];
      const ProfilePoint& q = profile[i];
      // Normal towards the pitch of the segment in (outward, height).
      const double dx = q.outward_m - p.outward_m;
      const double dz = q.height_m - p.height_m;
      const double length = std::hypot(dx, dz);
      if (length < 1e-9) continue;
      const double nx = -dz / length;
      const double nz = dx / length;
      const double facing = nx * out_d + nz * direction.z();
      if (facing >= -1e-12) continue;
      const double t = (nx * (p.outward_m - out0) + nz * (p.height_m - origin.z())) / facing;
      if (t <= 0 || (best && t >= best->distance)) continue;
      const double height = origin.z() + t * direction.z();
      const double outward = out0 + t * out_d;
      const bool steep = dz > std::abs(dx);
      if (steep ? height < p.height_m || height > q.height_m
                : outward < p.outward_m || outward > q.outward_m) {
        continue;
      }
      // Corners: inside the neighbours' profiles at this height.
      const int other = 1 - a.across;
      const double along = origin[other] + t * direction[other];
      const PitchSide neighbour = other == 0 ? (along < 0 ? PitchSide::kLeft : PitchSide::kRight)
                                             : (along < 0 ? PitchSide::kNear : PitchSide::kFar);
      const double limit =
          axes(stadium, neighbour).line + outward_at(stadium.side(neighbour).profile, height);
      if (std::abs(along) > limit + 1e-6) continue;
      StadiumHit hit;
      hit.distance = t;
      hit.side = side;
      hit.normal_in_world[a.across] = a.sign * nx;
      hit.normal_in_world.z() = nz;
      best = hit;
    }
  }
  return best;
}

}  // namespace touchline::render
