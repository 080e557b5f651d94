// What a simulated camera is: where it stands, its head, lens, operator, sensor and clock. Every
// length in pixels is of a picture `width` wide; resized() scales them along.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "shared/base/ids.h"
#include "shared/base/result.h"
#include "shared/base/time.h"
#include "shared/image/frame.h"

namespace touchline::sim::camera {

enum class Role : std::uint8_t { kMatch, kFixed, kCloseup };
enum class Side : std::uint8_t { kMain, kReverse, kLeft, kRight };

struct LensSpec {
  double wide_mm = 9;           // focal length on a 2/3 inch sensor, 9.59 mm wide; 3..3000
  double tele_mm = 180;         // at least wide_mm
  double corner_wide = -0.02;   // shift of the picture's corner over its radius; -0.08..0.08
  double corner_tele = 0.004;   // changes smoothly with log focal
  double fourth_share = -0.15;  // share of that shift which grows with the fourth power; -0.5..0.5
  Eigen::Vector2d centre_px{0, 0};  // principal point minus the picture's middle; -40..40
  double pupil_wide_m = 0;          // entrance pupil ahead of the head's axes; -0.5..0.5
  double pupil_tele_m = 0;          // linear in log focal between the two

  base::Status validate() const;
};

// A point on the way of a scripted camera. Between keys the wish is linear; the operator follows.
struct MotionKey {
  double time_s = 0;
  Eigen::Vector3d aim{0, 0, 0};    // world point in the picture's middle
  std::optional<double> focal_mm;  // one of the two
  std::optional<double> view_m;
};

enum class MotionKind : std::uint8_t { kFixed, kFollow, kKeys };

// How the head is moved. An operator is a damped spring with a delay that is drawn to the target.
struct MotionSpec {
  MotionKind kind = MotionKind::kFollow;
  std::string target = "ball";     // of kFollow: "ball" or the id of a person
  Eigen::Vector3d aim{0, 0, 0};    // of kFixed: world point in the picture's middle
  double aim_height_m = 0;         // of kFollow: height above the turf that is aimed at; 0..3
  std::optional<double> focal_mm;  // else what shows view_m
  double view_m = 36;              // width of the picture at the target; 0.5..300
  double delay_s = 0.15;           // 0..2
  double response_hz = 0.7;        // of the spring; 0.05..5
  double damping = 0.6;            // below 1 the head overshoots; 0.2..2
  double zoom_response_hz = 0.25;  // 0.05..5
  double wander_deg = 0.25;        // slow error of the wish, rms; 0..5
  double jitter_deg = 0.002;       // hand and wind, 2..9 Hz, rms; 0..0.2
  double most_speed_deg = 90;      // of pan and tilt, per second; 1..360
  double most_accel_deg = 240;     // per second squared; 10..2000
  std::vector<MotionKey> keys;     // of kKeys, rising times

  base::Status validate() const;
};

// The head and what it stands on.
struct MountSpec {
  Eigen::Vector3d position{0, -60, 14};  // where pan and tilt axes meet, pitch frame
  Eigen::Vector2d level_deg{0, 0};       // levelling error about X, then Y; -5..5
  double roll_deg = 0;                   // of the camera on the head; -10..10
  double sway_m = 0;                     // rms of the mount's place, each axis; 0..0.1
  double sway_deg = 0;                   // rms of its tilt to either side; 0..0.5
  double sway_hz = 0.8;                  // strongest frequency; the rest lies in 0.3..2 Hz

  base::Status validate() const;
};

// Raw encoder counts of head and lens; offsets come from the seed.
struct HeadSpec {
  bool encoders = false;
  double counts_per_deg = 2912.7;  // 2^20 counts a turn; 1..1e6
  double backlash_deg = 0.005;     // play between motor and camera; 0..0.5
  double zoom_counts = 16384;      // from wide to tele; 16..1e7
  double focus_counts = 16384;     // from infinity to 1 m; 16..1e7

  base::Status validate() const;
};

// High boost on luma: Y += level * (crisp(h * Y) + v_level * crisp(v * Y)).
struct DetailSpec {
  double level = 0;        // 0..1.5
  double frequency = 0.5;  // of the greatest horizontal boost, cycles a pixel; 0.26..0.5
  double v_level = 0.8;    // vertical over horizontal; 0..2
  double coring = 0;       // corrections below this share of white vanish; 0..0.1
  double clip = 1;         // and none is larger; 0.01..1

  base::Status validate() const;
};

enum class Sampling : std::uint8_t { k422, k420 };

struct SensorSpec {
  double exposure_stops = 0;      // against the scene's exposure; -4..4
  Eigen::Vector3d gain{1, 1, 1};  // of red, green, blue in linear light; 0.5..2
  double knee = 0.85;             // share of white where highlights bend; 0.3..1
  double knee_slope = 0.18;       // beyond it; 0..1
  double read_noise = 0.0015;     // rms, share of white in linear light; 0..0.1
  double shot_noise = 0.006;      // rms at white, falling with the root of light; 0..0.2
  double softness_px = 0.3;       // sigma of the lens' blur; 0..3
  DetailSpec detail;

  base::Status validate() const;
};

enum class Codec : std::uint8_t { kH264, kFfvhuff, kFfv1 };

struct VideoSpec {
  Codec codec = Codec::kH264;  // intra only; ffvhuff and ffv1 lose nothing
  int quality = 14;            // H.264 quantiser at 8 bits; 0 (10 bits: nearly all) .. 40
  int bits = 10;               // 8 or 10
  Sampling sampling = Sampling::k422;

  base::Status validate() const;
};

struct TimingSpec {
  std::optional<base::FrameRate> rate;  // else the recording's
  image::Scan scan = image::Scan::kProgressive;
  double shutter = 0.5;              // exposure over the frame's (field's) period; 0..1
  double offset_ms = 0;              // later than the nominal instant; -1000..1000
  bool offset_stated = true;         // recording.toml says so
  std::vector<std::int64_t> drop;    // exposures that never reach the video
  std::vector<std::int64_t> repeat;  // exposures lost to a copy of the one before
  double drop_share = 0;             // more of them by chance; 0..0.5
  double repeat_share = 0;
  double jitter_us = 0;  // of the exposure, rms; told in timing.csv; 0..10000

  base::Status validate() const;
};

struct CameraSpec {
  base::CameraId id;
  Role role = Role::kMatch;
  Side side = Side::kMain;
  int width = 1920;
  int height = 1080;
  MountSpec mount;
  LensSpec lens;
  MotionSpec motion;
  SensorSpec sensor;
  VideoSpec video;
  TimingSpec timing;
  HeadSpec head;
  int survey_stills = 14;                 // of a match camera; 0 or 3..40
  Eigen::Vector2d survey_view_m{90, 14};  // widest and closest, width at the pitch; 3..300
  double vary = 0;  // faults drawn by seed (gains, centre, levelling, detail, lens); 0..2

  base::Status validate() const;  // of all parts; where = "camera.<id>.<field>"
};

// The same camera with another picture size: focal lengths in millimetres stay.
CameraSpec resized(CameraSpec spec, int width, int height);
// The same camera with the faults that `vary` asks for added to its own.
CameraSpec varied(CameraSpec spec, std::uint64_t seed);
// What a camera of a role is unless a scene says otherwise.
CameraSpec usual(Role role);
// The side of the pitch a position lies on: the nearest one.
Side side_of(const Eigen::Vector3d& position, double length_m, double width_m);

enum class PathKind : std::uint8_t { kFixed, kOrbit, kReferee, kGoalkeeper, kOffside };

// A camera that exists in the truth only: ideal lens, no noise, no blur.
struct VirtualSpec {
  std::string id = "virtual01";  // "virtual" and two digits
  PathKind kind = PathKind::kFixed;
  int width = 1280;
  int height = 720;
  double focal_px = 1300;               // of a picture `width` wide; 100..20000
  Eigen::Vector3d position{0, -20, 4};  // of kFixed
  Eigen::Vector3d aim{0, 0, 1};         // of kFixed; the centre of kOrbit
  std::string target;                   // looked at instead of `aim`: "ball" or a person
  std::string person;                   // whose eye: kReferee, kGoalkeeper; on whose line: kOffside
  double radius_m = 15;                 // of kOrbit; the distance from the touchline of kOffside
  double height_m = 3;                  // of kOrbit and kOffside above the pitch frame
  double start_deg = -90;               // of kOrbit, from +X towards +Y
  double deg_per_s = 20;                // of kOrbit
  double eye_m = 1.72;                  // of kReferee and kGoalkeeper above the turf
  double ahead_m = 0.8;   // of an eye before the person's middle, who would fill the view; 0..3
  double smooth_s = 0.4;  // an eye's way and gaze are means over this time; 0..5
  int clean_every = 2;    // frames; 0 = never
  int matte_every = 2;

  base::Status validate() const;
};

}  // namespace touchline::sim::camera
