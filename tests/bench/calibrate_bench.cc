// Calibration of a moving head by lines, stage by stage. Peers: OpenCV's Canny, probabilistic Hough
// and LSD find line segments; with solvePnPRefineLM, which is given the right correspondences for
// nothing, they make a tracker that would still have to say which segment is which marking. Texture
// is what a frame without lines takes: found again in the views kept of frames before. Its peer
// follows corners from the frame before by Lucas and Kanade's flow and says no camera.
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "edge/calibrate/calibrator.h"
#include "edge/calibrate/initialise/hough_initialiser.h"
#include "edge/calibrate/lines/line_map.h"
#include "edge/calibrate/texture/plate_registration.h"
#include "edge/calibrate/track/line_tracker.h"
#include "edge/edge_config.h"
#include "tests/bench/bench.h"
#include "tests/bench/input.h"

namespace touchline::bench {
namespace {

constexpr auto kHead = recording::Role::kMatch;

const image::Frame& frame(Size size) { return *camera_frames(kHead, size).frames.front(); }
const geometry::CameraEstimate& truth(Size size) {
  return camera_frames(kHead, size).truth.front();
}

// The true camera turned by 0.05 degrees and zoomed by 0.3 %, with the covariance of such a guess.
geometry::CameraEstimate guess(Size size) {
  geometry::CameraEstimate out = truth(size);
  const double turn = 0.05 * 3.14159265358979 / 180;
  out.cam_from_world.rotation =
      Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY()) * out.cam_from_world.rotation;
  out.cam_from_world.translation =
      -(out.cam_from_world.rotation * geometry::position_in_world(truth(size)));
  out.model.fx *= 1.003;
  out.model.fy *= 1.003;
  out.covariance(0, 0) = out.covariance(1, 1) = turn * turn;
  out.covariance(2, 2) = 1e-8;
  out.covariance(3, 3) = 0.005 * 0.005;
  return out;
}

// Points of the markings that the true camera sees, metres, and their pixels.
void seen_points(Size size, std::vector<cv::Point3d>& points, std::vector<cv::Point2d>& pixels) {
  for (const pitch::Marking& marking : the_pitch().markings) {
    if (marking.shape == pitch::MarkingShape::kSpot) continue;
    for (double d = 0; d < marking.length(); d += 0.25) {
      const Eigen::Vector3d p = the_pitch().on_turf(marking.at(d));
      const auto pixel = geometry::project(truth(size), p);
      if (!pixel || !truth(size).model.sees(*pixel)) continue;
      points.emplace_back(p.x(), p.y(), p.z());
      pixels.emplace_back(pixel->x(), pixel->y());
    }
  }
}

double error_px(Size size, const geometry::CameraEstimate& found) {
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  seen_points(size, points, pixels);
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto p = geometry::project(found, {points[i].x, points[i].y, points[i].z});
    if (!p) return 1e3;
    sum += (*p - Eigen::Vector2d(pixels[i].x, pixels[i].y)).squaredNorm();
  }
  return points.empty() ? 1e3 : std::sqrt(sum / static_cast<double>(points.size()));
}

cv::Mat luma8(const image::Frame& from) {
  const image::Image<std::uint16_t>& luma = from.planes[0];
  const cv::Mat full(luma.height(), luma.width(), CV_16UC1,
                     const_cast<std::uint16_t*>(luma.data()));
  cv::Mat out;
  full.convertTo(out, CV_8U, 0.25);
  return out;
}

void track(benchmark::State& state, Size size) {
  const calibrate::LineTracker tracker(the_pitch(), mount(kHead, size), {});
  const geometry::CameraEstimate prior = guess(size);
  state::TrackResult result;
  state.counters["peak_mib"] = peak_mib([&] { result = tracker.track(frame(size), prior); });
  if (result.estimate.lost()) return state.SkipWithError(result.report.stopped_because.c_str());
  state.counters["error_px"] = error_px(size, result.estimate);
  if (error_px(size, result.estimate) > 4) return state.SkipWithError("not the true camera");
  for (auto _ : state) benchmark::DoNotOptimize(tracker.track(frame(size), prior));
}

void canny_and_pnp(benchmark::State& state, Size size) {
  const cv::Mat luma = luma8(frame(size));
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  seen_points(size, points, pixels);
  const geometry::CameraEstimate prior = guess(size);
  const Eigen::Matrix3d r = prior.cam_from_world.rotation.toRotationMatrix();
  const Eigen::Vector3d t = prior.cam_from_world.translation;
  const cv::Mat rotation = (cv::Mat_<double>(3, 3) << r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1),
                            r(1, 2), r(2, 0), r(2, 1), r(2, 2));
  const geometry::CameraModel& m = truth(size).model;
  const cv::Mat camera = (cv::Mat_<double>(3, 3) << m.fx, 0, m.cx, 0, m.fy, m.cy, 0, 0, 1);
  const cv::Mat lens = (cv::Mat_<double>(1, 4) << m.k1, m.k2, 0, 0);
  for (auto _ : state) {
    cv::Mat edges;
    std::vector<cv::Vec4i> segments;
    cv::Canny(luma, edges, 40, 120);
    cv::HoughLinesP(edges, segments, 1, CV_PI / 720, 80, 60, 6);
    cv::Mat turn;
    cv::Rodrigues(rotation, turn);
    cv::Mat shift = (cv::Mat_<double>(3, 1) << t.x(), t.y(), t.z());
    cv::solvePnPRefineLM(points, pixels, camera, lens, turn, shift);
    benchmark::DoNotOptimize(shift.data);
  }
}

void register_texture(benchmark::State& state, Size size) {
  const CameraFrames& shot = camera_frames(kHead, size);
  calibrate::PlateRegistration registration(mount(kHead, size), {});
  geometry::CameraEstimate known = shot.truth.front();
  known.evidence = geometry::Evidence::kLines;
  known.covariance(0, 0) = known.covariance(1, 1) = 1e-10;
  registration.learn(*shot.frames.front(), known);
  const image::Frame& next = *shot.frames.at(1);
  const geometry::CameraEstimate prior = guess(size);
  calibrate::Registration result;
  state.counters["peak_mib"] = peak_mib([&] { result = registration.track(next, prior); });
  if (result.lost()) return state.SkipWithError(result.result.report.stopped_because.c_str());
  state.counters["patches"] = result.result.report.points;
  for (auto _ : state) benchmark::DoNotOptimize(registration.track(next, prior));
}

void corner_flow(benchmark::State& state, Size size) {
  const CameraFrames& shot = camera_frames(kHead, size);
  const cv::Mat before = luma8(*shot.frames.front());
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(before, corners, 360, 0.001, 20);
  for (auto _ : state) {
    const cv::Mat now = luma8(*shot.frames.at(1));
    std::vector<cv::Point2f> moved;
    std::vector<unsigned char> found;
    cv::calcOpticalFlowPyrLK(before, now, corners, moved, found, cv::noArray(), {11, 11}, 4);
    cv::Mat similarity = cv::estimateAffinePartial2D(corners, moved);
    benchmark::DoNotOptimize(similarity.data);
  }
}

void map_lines(benchmark::State& state, Size size) {
  calibrate::LineMap map;
  state.counters["peak_mib"] =
      peak_mib([&] { map = calibrate::detect_lines(frame(size), calibrate::LineMapOptions()); });
  if (map.points.empty()) return state.SkipWithError("no lines");
  for (auto _ : state) {
    benchmark::DoNotOptimize(calibrate::detect_lines(frame(size), calibrate::LineMapOptions()));
  }
}

void canny(benchmark::State& state, Size size) {
  const cv::Mat luma = luma8(frame(size));
  for (auto _ : state) {
    cv::Mat edges;
    std::vector<cv::Vec4i> segments;
    cv::Canny(luma, edges, 40, 120);
    cv::HoughLinesP(edges, segments, 1, CV_PI / 720, 80, 60, 6);
    benchmark::DoNotOptimize(segments.data());
  }
}

void segments(benchmark::State& state, Size size) {
  const cv::Mat luma = luma8(frame(size));
  const auto detector = cv::createLineSegmentDetector();
  for (auto _ : state) {
    cv::Mat found;
    detector->detect(luma, found);
    benchmark::DoNotOptimize(found.data);
  }
}

void initialise(benchmark::State& state, Size size) {
  const calibrate::Initialiser initialiser(the_pitch(), mount(kHead, size), {});
  const auto map = calibrate::detect_lines(frame(size), {});
  std::optional<geometry::CameraEstimate> found;
  state.counters["peak_mib"] = peak_mib([&] { found = initialiser.find(map); });
  state.counters["found"] = found.has_value();
  if (found) {
    state.counters["error_px"] = error_px(size, *found);
    if (error_px(size, *found) > 20) return state.SkipWithError("not the true camera");
  }
  for (auto _ : state) benchmark::DoNotOptimize(initialiser.find(map));
}

void solve_survey(benchmark::State& state, recording::Role role) {
  const Survey& done = survey(role);
  state.counters["rms_px"] = done.result.rms_px;
  const edge::ChainSetup setup = must(edge::chain_setup(the_recording(), first_camera(role).id));
  const auto again = [&] {
    if (role == kHead) return calibrate::survey(done.stills, the_pitch(), setup.side, {});
    std::vector<image::Frame> frames;
    for (const auto& f : camera_frames(role, Size::k1080).frames) {
      if (frames.size() < 6) frames.push_back(*f);
    }
    return calibrate::survey_fixed(frames, the_pitch(), setup.side, {});
  };
  for (auto _ : state) {
    if (!again()) return state.SkipWithError("not solved");
  }
}

void add_all() {
  for (const Size size : kSizes) {
    add("track", kOurs, name(size), [=](auto& state) { track(state, size); });
    add("track", "OpenCV Canny, HoughLinesP, solvePnPRefineLM", name(size),
        [=](auto& state) { canny_and_pnp(state, size); });
    add("texture", kOurs, name(size), [=](auto& state) { register_texture(state, size); });
    add("texture", "OpenCV corners, calcOpticalFlowPyrLK", name(size),
        [=](auto& state) { corner_flow(state, size); });
    add("line map", kOurs, name(size), [=](auto& state) { map_lines(state, size); });
    add("line map", "OpenCV Canny, HoughLinesP", name(size),
        [=](auto& state) { canny(state, size); });
    add("line map", "OpenCV LSD", name(size), [=](auto& state) { segments(state, size); });
    add("initialise", kOurs, name(size), [=](auto& state) { initialise(state, size); });
  }
  if (smoke()) return;  // track has surveyed the head already
  add("survey", kOurs, "1080p head", [](auto& state) { solve_survey(state, kHead); }).once();
  add("survey", kOurs, "1080p fixed", [](auto& state) {
    solve_survey(state, recording::Role::kFixed);
  }).once();
}

}  // namespace
}  // namespace touchline::bench

int main(int argc, char** argv) {
  touchline::bench::add_all();
  return touchline::bench::run(argc, argv);
}
