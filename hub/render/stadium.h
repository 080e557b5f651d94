// What stands round the turf, as simple geometry: on each side of the pitch one profile (hoarding,
// wall, stand) that is extruded along the side. Found by a plane sweep over the plates.
#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include "shared/base/ids.h"
#include "shared/base/result.h"
#include "shared/image/plate_snapshot.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::render {

enum class PitchSide : std::uint8_t { kNear, kFar, kLeft, kRight };  // y < 0, y > 0, x < 0, x > 0
std::string_view name(PitchSide side);

// A point of a profile: metres outward from the line (touchline, or goal/dead-ball line), metres
// above world zero.
struct ProfilePoint {
  double outward_m = 0;
  double height_m = 0;
};

// From the foot of the hoarding upward; outward and height never fall.
struct StadiumSide {
  std::vector<ProfilePoint> profile;
  bool measured = false;  // false: the default profile, no two plates agreed
  double agreement = 0;   // mean correlation between plates on the profile, -1..1
};

struct Stadium {
  double half_length_m = 52.5;  // where `outward` counts from
  double half_width_m = 34;
  std::array<StadiumSide, 4> sides;  // by PitchSide

  const StadiumSide& side(PitchSide s) const { return sides[static_cast<std::size_t>(s)]; }
};

struct StadiumOptions {
  double margin_m = 5;           // default distance of the hoarding beyond the line; 1..50
  double hoarding_m = 1.0;       // default height of the hoarding; 0.2..5
  double stand_slope_deg = 30;   // default rise of the stand behind it; 5..89
  double top_m = 25;             // height at which profiles end; 5..100
  double least_margin_m = 2;     // nearest hoarding that is tried; 0.5..20
  double most_margin_m = 12;     // farthest; 1..60
  double least_agreement = 0.5;  // correlation from which a measured profile is believed; 0..1

  base::Status validate() const;
};

// The default geometry for a pitch.
Stadium default_stadium(const pitch::PitchModel& pitch, const StadiumOptions& options = {});

// Profiles that make the plates agree best, by dynamic programming over height; sides that no two
// plates share keep the default.
Stadium estimate_stadium(const pitch::PitchModel& pitch,
                         const std::map<base::CameraId, image::PlateSnapshot>& plates,
                         const StadiumOptions& options = {});

// Where a ray first meets the inside of the stadium (surfaces that face the pitch).
struct StadiumHit {
  double distance = 0;  // in units of the direction's length
  PitchSide side{};
  Eigen::Vector3d normal_in_world = Eigen::Vector3d::Zero();  // towards the pitch
};
std::optional<StadiumHit> intersect(const Stadium& stadium, const Eigen::Vector3d& origin_in_world,
                                    const Eigen::Vector3d& direction_in_world);

}  // namespace touchline::render
