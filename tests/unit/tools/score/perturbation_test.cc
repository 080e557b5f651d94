// A known error scores what geometry predicts; the predictions are computed here, apart from the
// scorer's own code.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "shared/geometry/mount.h"
#include "tests/unit/tools/score/true_exports.h"
#include "tools/score/body_map.h"
#include "tools/score/camera_score.h"
#include "tools/score/hull_score.h"
#include "tools/score/view_score.h"

namespace touchline::score {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;

// Turns a camera about the vertical through its own position.
void pan_by(recording::CameraRow& row, double radians) {
  const Eigen::Vector3d eye = geometry::origin(row.cam_from_world);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(radians, Eigen::Vector3d::UnitZ()));
  row.cam_from_world.rotation = row.cam_from_world.rotation * turn;
  row.cam_from_world.translation = -(row.cam_from_world.rotation * eye);
}

// The mean square image motion of a small turn `w` of the camera (in its own axes) over a picture,
// by the flow of a rotating pinhole (Longuet-Higgins and Prazdny 1980), at pixels of the turf.
double flow_rms(const recording::CameraRow& row, const Eigen::Vector3d& w,
                const pitch::PitchModel& pitch) {
  const Eigen::Matrix3d r = row.cam_from_world.rotation.toRotationMatrix();
  double sum = 0;
  int count = 0;
  for (int gx = -56; gx <= 56; ++gx) {
    for (int gy = -38; gy <= 38; ++gy) {
      const Eigen::Vector3d p =
          r * Eigen::Vector3d(gx, gy, pitch.turf_z(gy)) + row.cam_from_world.translation;
      const double x = p.x() / p.z();
      const double y = p.y() / p.z();
      const double u = row.model.fx * x + row.model.cx;
      const double v = row.model.fx * y + row.model.cy;
      if (p.z() <= 0 || u < 0 || v < 0 || u > 1919 || v > 1079) continue;
      const double du = row.model.fx * (x * y * w.x() - (1 + x * x) * w.y() + y * w.z());
      const double dv = row.model.fx * ((1 + y * y) * w.x() - x * y * w.y() - x * w.z());
      sum += du * du + dv * dv;
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

TEST(Perturbation, ATenthOfADegreeOfPan) {
  const TrueExports exports;
  constexpr double kTurn = 0.1 * kDegree;
  std::map<std::string, double> predicted;
  std::map<std::string, int> rows;
  const auto pitch = pitch::make_pitch(exports.recording().sport, exports.recording().sizes);
  ASSERT_TRUE(pitch);
  exports.write_cameras([&](const std::string& camera, recording::CameraRow& row) {
    const Eigen::Vector3d about = row.cam_from_world.rotation * Eigen::Vector3d(0, 0, kTurn);
    predicted[camera] += flow_rms(row, about, *pitch);
    ++rows[camera];
    pan_by(row, kTurn);
  });
  const auto report = exports.score();
  ASSERT_TRUE(report) << to_string(report.error());
  for (const auto& [camera, sum] : predicted) {
    const double rms = sum / rows[camera];
    // The prediction knows no lens distortion.
    EXPECT_NEAR(figure(*report, "cameras", "rms on a 1 m grid", camera), rms, 0.06 * rms) << camera;
  }
  EXPECT_NEAR(figure(*report, "cameras", "pan error"), 0.1, 1e-5);
  EXPECT_NEAR(figure(*report, "cameras", "pan error over stated sd"), 10, 1e-3);
  EXPECT_LT(figure(*report, "cameras", "tilt error"), 1e-5);
  EXPECT_LT(figure(*report, "cameras", "position error"), 1e-6);
  EXPECT_LT(figure(*report, "cameras", "pan noise"), 1e-6);  // it is the same in every frame
}

TEST(Perturbation, AnErrorOfTheStatedSizeScoresOne) {
  const TrueExports exports;
  constexpr double kTurn = 0.1 * kDegree;
  exports.write_cameras([&](const std::string&, recording::CameraRow& row) {
    pan_by(row, kTurn);
    row.report->sd_pan_deg = 0.1 / std::sqrt(3.0);  // a third of the sum of three squares
    row.report->sd_tilt_deg = row.report->sd_focal_rel = 1;
  });
  const auto report = exports.score();
  ASSERT_TRUE(report) << to_string(report.error());
  EXPECT_NEAR(figure(*report, "cameras", "normalised square error, all frames"), 1, 1e-3);
  EXPECT_LT(figure(*report, "cameras", "normalised square error, between frames"), 1e-6);
}

TEST(Perturbation, NoiseOfTheStatedSizeScoresOneBetweenFrames) {
  const TrueExports exports;
  std::map<std::string, int> seen;
  exports.write_cameras([&](const std::string& camera, recording::CameraRow& row) {
    pan_by(row, (seen[camera]++ % 2 == 0 ? 0.1 : -0.1) * kDegree);
    row.report->sd_pan_deg = 0.1 / std::sqrt(3.0);
    row.report->sd_tilt_deg = row.report->sd_focal_rel = 1;
  });
  const auto report = exports.score();
  ASSERT_TRUE(report) << to_string(report.error());
  EXPECT_NEAR(figure(*report, "cameras", "normalised square error, between frames"), 1, 0.1);
  EXPECT_LT(figure(*report, "cameras", "normalised square error, all frames"), 0.1);
}

TEST(MeanSquareBand, IsThatOfChiSquare) {
  // Tables: 0.352 and 7.815 for 3 degrees of freedom, 18.493 and 43.773 for 30.
  EXPECT_NEAR(mean_square_band(3)[0], 0.352 / 3, 0.01);
  EXPECT_NEAR(mean_square_band(3)[1], 7.815 / 3, 0.02);
  EXPECT_NEAR(mean_square_band(30)[0], 18.493 / 30, 0.002);
  EXPECT_NEAR(mean_square_band(30)[1], 43.773 / 30, 0.002);
}

TEST(Perturbation, PanThatTrembles) {
  const TrueExports exports;
  exports.write_cameras([](const std::string&, recording::CameraRow& row) {
    pan_by(row, (row.frame % 2 == 0 ? 0.01 : -0.01) * kDegree);
  });
  const auto report = exports.score();
  ASSERT_TRUE(report) << to_string(report.error());
  // Over ten frames every second holds them all, and their mean is 0.
  EXPECT_NEAR(figure(*report, "cameras", "pan noise"), 0.01, 1e-5);
}

TEST(WithoutSlowPart, TakesAwayTheMeanOfTheSecondRound) {
  std::vector<double> times;
  std::vector<double> values;
  for (int i = 0; i < 200; ++i) {
    times.push_back(i / 25.0);
    values.push_back(0.3 * i / 25.0 + (i % 2 == 0 ? 1 : -1));
  }
  const auto left = without_slow_part(times, values);
  // Of 25 frames of alternating sign one is left over: the mean is 1/25 with the sign of the ends.
  for (std::size_t i = 20; i < 180; ++i) {
    ASSERT_TRUE(left[i]);
    EXPECT_NEAR(std::abs(*left[i]), 1 - 1.0 / 25, 1e-9) << i;
  }
  EXPECT_FALSE(without_slow_part(std::vector<double>{0, 1}, std::vector<double>{5, 6})[0]);
}

// A camera that looks straight down on the centre circle sees a turn about its axis and a shift of
// the picture as they are.
TEST(CountMarkings, CountsWhatIsWithinTheDistance) {
  const auto pitch = pitch::make_pitch(pitch::Sport::kSoccer, {});
  ASSERT_TRUE(pitch);
  geometry::CameraEstimate camera;
  camera.model = {1920, 1080, 1400, 1400, 959.5, 539.5, 0, 0};
  camera.cam_from_world.rotation = geometry::cam_from_reference(0, -90 * kDegree, 0);
  camera.cam_from_world.translation = -(camera.cam_from_world.rotation * Eigen::Vector3d(0, 0, 40));
  // It sees 54.9 m by 30.9 m: halfway line, circle, spot, nothing else.
  const auto same = count_markings(camera, camera, *pitch);
  EXPECT_EQ(same[0].right, 3);
  EXPECT_EQ(same[0].all(), 3);
  // 12 px of shift along the halfway line are 6 px at half the size: circle and spot are off by
  // that, the line lies upon itself.
  geometry::CameraEstimate shifted = camera;
  shifted.model.cy += 12;
  const auto counts = count_markings(camera, shifted, *pitch);
  EXPECT_EQ(counts[0].right, 1);
  EXPECT_EQ(counts[0].wrong, 2);
  EXPECT_EQ(counts[1].right, 3);
  EXPECT_DOUBLE_EQ(*counts[0].jaccard(), 1.0 / 3);
  // Seen by one alone.
  geometry::CameraEstimate aside = camera;
  aside.cam_from_world.translation.x() -= 45;
  EXPECT_GT(count_markings(camera, aside, *pitch)[2].missed, 0);
  EXPECT_GT(count_markings(aside, camera, *pitch)[2].wrong, 0);
}

void dilate_by_one(image::Image<std::uint8_t>& matte) {
  const image::Image<std::uint8_t> from = matte;
  for (int y = 0; y < matte.height(); ++y) {
    for (int x = 0; x < matte.width(); ++x) {
      for (int d = -1; d <= 1; ++d) {
        if (from.contains(x + d, y)) matte(x, y) = std::max(matte(x, y), from(x + d, y));
        if (from.contains(x, y + d)) matte(x, y) = std::max(matte(x, y), from(x, y + d));
      }
    }
  }
}

TEST(Perturbation, OnePixelOfMatte) {
  const TrueExports exports;
  double before = 0;
  double after = 0;
  exports.write_mattes("m1", [&](std::int64_t, image::Image<std::uint8_t>& matte) {
    const auto count = [&] {
      return std::count_if(matte.data(), matte.data() + matte.size(),
                           [](std::uint8_t a) { return a >= 128; });
    };
    before += static_cast<double>(count());
    dilate_by_one(matte);
    after += static_cast<double>(count());
  });
  const auto report = exports.score();
  ASSERT_TRUE(report) << to_string(report.error());
  EXPECT_NEAR(figure(*report, "mattes", "IoU at 0.5"), 100 * before / after, 1e-6);
  EXPECT_NEAR(figure(*report, "mattes", "extra"), 100 * (after / before - 1), 1e-6);
  EXPECT_EQ(figure(*report, "mattes", "missing"), 0);
  EXPECT_NEAR(figure(*report, "mattes", "boundary distance"), 1, 0.06);
  EXPECT_EQ(figure(*report, "mattes", "limb recall"), 100);
  EXPECT_EQ(figure(*report, "mattes", "false foreground on turf"), 0);
}

// A closed box whose vertices are a grid of 5 cm on its sides.
geometry::Mesh box_of_grid(const Eigen::Vector3f& low, int nx, int ny, int nz) {
  constexpr float kStep = 0.05F;
  geometry::Mesh mesh;
  const std::array<int, 3> n = {nx, ny, nz};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t b = (axis + 1) % 3;
    const std::size_t c = (axis + 2) % 3;
    for (const bool far : {false, true}) {
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      for (int j = 0; j <= n[b]; ++j) {
        for (int k = 0; k <= n[c]; ++k) {
          Eigen::Vector3f at = Eigen::Vector3f::Zero();
          at[static_cast<Eigen::Index>(axis)] = far ? kStep * static_cast<float>(n[axis]) : 0;
          at[static_cast<Eigen::Index>(b)] = kStep * static_cast<float>(j);
          at[static_cast<Eigen::Index>(c)] = kStep * static_cast<float>(k);
          mesh.vertices.push_back(low + at);
        }
      }
      const auto row = static_cast<std::uint32_t>(n[c] + 1);
      for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(n[b]); ++j) {
        for (std::uint32_t k = 0; k < static_cast<std::uint32_t>(n[c]); ++k) {
          const std::uint32_t v = first + j * row + k;
          if (far) {
            mesh.triangles.push_back({v, v + row, v + row + 1});
            mesh.triangles.push_back({v, v + row + 1, v + 1});
          } else {
            mesh.triangles.push_back({v, v + row + 1, v + row});
            mesh.triangles.push_back({v, v + 1, v + row + 1});
          }
        }
      }
    }
  }
  return mesh;
}

// One component of box_of_grid: its six sides share no vertices, so they are welded.
geometry::Mesh welded(const geometry::Mesh& mesh) {
  geometry::Mesh out;
  std::map<std::array<int, 3>, std::uint32_t> at;
  std::vector<std::uint32_t> number;
  for (const Eigen::Vector3f& v : mesh.vertices) {
    const std::array<int, 3> key = {static_cast<int>(std::lround(v.x() * 1000)),
                                    static_cast<int>(std::lround(v.y() * 1000)),
                                    static_cast<int>(std::lround(v.z() * 1000))};
    const auto [found, fresh] = at.try_emplace(key, out.vertices.size());
    if (fresh) out.vertices.push_back(v);
    number.push_back(found->second);
  }
  for (const auto& t : mesh.triangles) {
    out.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
  }
  return out;
}

TEST(Perturbation, TwoCentimetresOfHull) {
  const geometry::Mesh truth = welded(box_of_grid({0, 0, 0}, 8, 6, 36));
  const std::vector<TruePerson> people = {{"A1", "A", "player", {0.2, 0.15, 0}}};
  geometry::CameraEstimate camera;
  camera.model = {1920, 1080, 1800, 1800, 959.5, 539.5, 0, 0};
  camera.cam_from_world.rotation = geometry::cam_from_reference(0, -0.1, 0);
  camera.cam_from_world.translation =
      -(camera.cam_from_world.rotation * Eigen::Vector3d(0, -40, 4));
  const std::vector<geometry::CameraEstimate> cameras = {camera, camera};
  // The hull lies 5 mm outside the truth, all round, then moves by 20 mm along x.
  const auto grown = [&](float by, float shift) {
    geometry::Mesh hull = truth;
    for (Eigen::Vector3f& v : hull.vertices) {
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const std::array<float, 3> high = {0.4F, 0.3F, 1.8F};
        if (v[axis] < 1e-4F) {
          v[axis] -= by;
        } else if (v[axis] > high[static_cast<std::size_t>(axis)] - 1e-4F) {
          v[axis] += by;
        }
      }
      v.x() += shift;
    }
    return hull;
  };
  EXPECT_EQ(score_hull(grown(0.005F, 0), truth, people, cameras, 0).all_share, 1);
  // Vertices of the side x = 0 are now 15 mm outside: beyond a reach of 10 mm, within one of 20.
  const double side = 7 * 37;
  const double all = static_cast<double>(truth.vertices.size());
  const HullScore near = score_hull(grown(0.005F, 0.02F), truth, people, cameras, 0.01);
  EXPECT_NEAR(near.all_share, 1 - side / all, 1e-9);
  EXPECT_NEAR(near.least_share(), 1 - side / all, 1e-9);
  EXPECT_EQ(score_hull(grown(0.005F, 0.02F), truth, people, cameras, 0.02).all_share, 1);
  EXPECT_NEAR(near.volume_m3, 0.41 * 0.31 * 1.81, 1e-5);
  EXPECT_EQ(near.phantoms, 0U);
  // Moved by 3 m it touches nobody.
  const HullScore away = score_hull(grown(0.005F, 3), truth, people, cameras, 0.02);
  EXPECT_EQ(away.phantoms, 1U);
  EXPECT_EQ(away.all_share, 0);
}

// Exports of frame k + 1 under the number k: errors are what moved in a frame.
TEST(Perturbation, OneFrameOfOffset) {
  const TrueExports exports;
  double squares = 0;
  int rows = 0;
  const auto pan_of = [&](const std::string& camera, std::int64_t frame) {
    const auto c = exports.truth().camera({camera}, frame);
    const Eigen::Vector3d d = c->cam_from_world.rotation.conjugate() * Eigen::Vector3d(0, 0, 1);
    return std::atan2(d.x(), d.y()) / kDegree;
  };
  exports.write_cameras([&](const std::string& camera, recording::CameraRow& row) {
    const auto next = exports.truth().camera({camera}, row.frame + 1);
    if (!next) {
      row.report->state = geometry::Evidence::kLost;
      return;
    }
    if (camera == "m3") {
      squares += std::pow(pan_of(camera, row.frame + 1) - pan_of(camera, row.frame), 2);
      ++rows;
    }
    row.model = next->model;
    row.cam_from_world = next->cam_from_world;
  });
  std::map<std::pair<std::int64_t, std::string>, Eigen::Vector3d> next;
  for (const std::int64_t frame : exports.truth().people_frames()) {
    for (const TruePerson& p : exports.truth().people(frame)) {
      next[{frame - 1, p.id}] = p.position_in_world;
    }
  }
  double moved = 0;
  double people = 0;
  exports.write_people([&](TruePerson& person, std::int64_t frame) {
    const auto at = next.find({frame, person.id});
    const Eigen::Vector3d then = at == next.end() ? person.position_in_world : at->second;
    if (!person.is_ball()) {
      moved += (then - person.position_in_world).head<2>().norm();
      ++people;
    }
    person.position_in_world = then;
  });
  const auto report = exports.score();
  ASSERT_TRUE(report) << to_string(report.error());
  ASSERT_GT(rows, 5);
  EXPECT_NEAR(figure(*report, "cameras", "pan error", "m3"), std::sqrt(squares / rows), 1e-6);
  EXPECT_NEAR(figure(*report, "cameras", "frames solved", "m3"), 90, 1e-9);
  EXPECT_NEAR(figure(*report, "people", "position error"), moved / people, 1e-6);
}

// A camera that looks along y at a person with four limbs of 30 cm, 10 m away, side by side: each
// capsule is a strip of 2 r by L with two half discs.
TEST(Perturbation, OneLimbOfFour) {
  geometry::CameraEstimate camera;
  camera.model = {800, 600, 2000, 2000, 399.5, 299.5, 0, 0};
  camera.cam_from_world.rotation = geometry::cam_from_reference(0, 0, 0);
  camera.cam_from_world.translation =
      -(camera.cam_from_world.rotation * Eigen::Vector3d(0, -10, 1));
  const std::vector<TruePerson> people = {{"A1", "A", "player", {0, 0, 0}}};
  std::vector<TrueJoint> joints;
  const char* const pairs[4][2] = {
      {"lelbow", "lwrist"}, {"relbow", "rwrist"}, {"lknee", "lankle"}, {"rknee", "rankle"}};
  for (int i = 0; i < 4; ++i) {
    const double x = 0.3 * (i - 1.5);
    joints.push_back({"A1", pairs[i][0], {x, 0, 1.2}});
    joints.push_back({"A1", pairs[i][1], {x, 0, 0.9}});
  }
  const image::Image<std::uint8_t> matte(800, 600, 255);
  const auto limbs = limb_map(matte, camera, people, joints);
  const double pixels =
      static_cast<double>(std::count(limbs.data(), limbs.data() + limbs.size(), std::uint8_t{0}));
  const double scale = 2000.0 / 10;
  const double capsule = (2 * 0.06 * 0.3 + 3.14159265 * 0.06 * 0.06) * scale * scale;
  EXPECT_NEAR(pixels, 4 * capsule, 0.02 * 4 * capsule);
}

TEST(Perturbation, AForearmThatIsNotKeyed) {
  const TrueExports exports;
  const std::string who = "A9";
  double erased = 0;
  exports.write_mattes("m3", [&](std::int64_t frame, image::Image<std::uint8_t>& matte) {
    const auto camera = exports.truth().camera({"m3"}, frame);
    Eigen::Vector3d elbow = Eigen::Vector3d::Zero();
    Eigen::Vector3d wrist = elbow;
    for (const TrueJoint& joint : exports.truth().joints(frame)) {
      if (joint.person != who) continue;
      if (joint.joint == "relbow") elbow = joint.position_in_world;
      if (joint.joint == "rwrist") wrist = joint.position_in_world;
    }
    // By rays: a pixel is in the capsule where its ray passes the segment within 6 cm.
    const Eigen::Vector3d eye = geometry::position_in_world(*camera);
    for (int y = 0; y < matte.height(); ++y) {
      for (int x = 0; x < matte.width(); ++x) {
        if (matte(x, y) < 128) continue;
        const Eigen::Vector3d ray = geometry::ray_in_world(*camera, {x, y});
        double least = 1;
        for (int i = 0; i <= 20; ++i) {
          const Eigen::Vector3d p = elbow + (wrist - elbow) * (i / 20.0) - eye;
          least = std::min(least, (p - p.dot(ray) * ray).norm());
        }
        if (least > 0.06) continue;
        matte(x, y) = 0;
        ++erased;
      }
    }
  });
  const auto report = exports.score();
  ASSERT_TRUE(report) << to_string(report.error());
  ASSERT_GT(erased, 100);
  const Series* recall = report->find("mattes", "limb recall by person", who);
  const Series* all = report->find("mattes", "limb recall", "m3");
  ASSERT_TRUE(recall != nullptr && all != nullptr);
  double limb_px = 0;
  for (const Sample& sample : all->samples) limb_px += sample.weight;
  // What was erased is what is missing of the limbs of all.
  EXPECT_NEAR((100 - all->summary.mean) / 100 * limb_px, erased, 0.03 * erased + 10);
  EXPECT_LT(recall->summary.mean, 90);
  EXPECT_GT(recall->summary.mean, 50);  // three of four are there
}

TEST(Perturbation, TwoPixelsOfPicture) {
  const TrueExports exports;
  exports.write_views(2);
  const auto report = exports.score();
  ASSERT_TRUE(report) << to_string(report.error());
  EXPECT_NEAR(figure(*report, "views", "misalignment"), 2, 0.01);
  EXPECT_GT(figure(*report, "views", "PSNR aligned"), 60);
  // formats.md: about 15 dB.
  EXPECT_NEAR(figure(*report, "views", "PSNR of people"), 15, 3);
  // As much is missing on one side of everybody as is phantom on the other.
  EXPECT_NEAR(figure(*report, "views", "missing foreground"),
              figure(*report, "views", "phantom foreground"), 0.5);
}

// Even noise of +-d has a mean square of d^2; its sign turns from frame to frame.
TEST(ViewScore, NoiseScoresItsOwnPower) {
  Picture clean(64, 48, {100, 120, 90});
  Picture noisy = clean;
  Picture turned = clean;
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      const int d = (x + y) % 2 == 0 ? 5 : -5;
      const auto with = [&](int by) {
        return image::Rgb8{static_cast<std::uint8_t>(100 + by), static_cast<std::uint8_t>(120 + by),
                           static_cast<std::uint8_t>(90 + by)};
      };
      noisy(x, y) = with(d);
      turned(x, y) = with(-d);
    }
  }
  const Mask everywhere(64, 48, 255);
  EXPECT_NEAR(psnr_db(clean, noisy, everywhere), 20 * std::log10(255.0 / 5), 1e-9);
  Picture brighter(64, 48, {120, 140, 110});
  const Flicker still = flicker(clean, noisy, brighter, noisy, everywhere);
  EXPECT_NEAR(still.clean_change / (64 * 48), 20, 1e-3);
  EXPECT_NEAR(still.error_change / (64 * 48), 20, 1e-3);
  const Flicker trembling = flicker(clean, noisy, clean, turned, everywhere);
  EXPECT_NEAR(trembling.error_change / (64 * 48), 10, 1e-3);
}

}  // namespace
}  // namespace touchline::score
