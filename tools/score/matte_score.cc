#include "tools/score/matte_score.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "tools/score/body_map.h"
#include "tools/score/score_context.h"

namespace touchline::score {

namespace {

constexpr std::uint8_t kForeground = 128;
constexpr float kMostDistance = 20;
constexpr float kNearPx = 1;

const ScoreKind kDelivered{"mattes",        "frames with a matte", "%",
                           Better::kHigher, Statistic::kMean,      1};
const ScoreKind kBoundary{"mattes", "boundary distance", "px", Better::kLower, Statistic::kMean, 3};
const ScoreKind kBoundaryF{"mattes",        "boundary F at 1 px", "%",
                           Better::kHigher, Statistic::kMean,     2};
const ScoreKind kMissing{"mattes", "missing", "%", Better::kLower, Statistic::kMean, 2};
const ScoreKind kExtra{"mattes", "extra", "%", Better::kLower, Statistic::kMean, 2};
const ScoreKind kAlpha{"mattes", "alpha error", "%", Better::kLower, Statistic::kMean, 2};
const ScoreKind kIou{"mattes", "IoU at 0.5", "%", Better::kHigher, Statistic::kMean, 2};
const ScoreKind kFalse{"mattes",       "false foreground on turf", "ppm",
                       Better::kLower, Statistic::kMean,           1};
const ScoreKind kLimbs{"mattes", "limb recall", "%", Better::kHigher, Statistic::kMean, 2};
const ScoreKind kMissingOf{"mattes", "missing by person", "%", Better::kLower, Statistic::kMean, 2};
const ScoreKind kLimbsOf{"mattes",        "limb recall by person", "%",
                         Better::kHigher, Statistic::kMean,        2};

double ratio(double part, double whole) { return whole > 0 ? part / whole : 0; }

// A view of `image` without a copy.
cv::Mat mat_of(const image::Image<std::uint8_t>& image) {
  return {image.height(), image.width(), CV_8UC1, const_cast<std::uint8_t*>(image.data())};
}

// 255 on foreground pixels that have a neighbour (of 4) outside.
cv::Mat boundary_of(const cv::Mat& mask) {
  cv::Mat inner;
  cv::erode(mask, inner, cv::getStructuringElement(cv::MORPH_CROSS, {3, 3}));
  return mask - inner;
}

struct Distances {
  double sum = 0, count = 0, near = 0;
};

Distances distances(const cv::Mat& of, const cv::Mat& to) {
  cv::Mat away;
  cv::distanceTransform(255 - to, away, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  Distances out;
  for (int y = 0; y < of.rows; ++y) {
    const std::uint8_t* at = of.ptr<std::uint8_t>(y);
    const float* far = away.ptr<float>(y);
    for (int x = 0; x < of.cols; ++x) {
      if (!at[x]) continue;
      out.sum += static_cast<double>(std::min(far[x], kMostDistance));
      out.near += far[x] <= kNearPx + 1e-3F;
      ++out.count;
    }
  }
  return out;
}

// What is compared: one frame of one camera.
struct FrameTask {
  const recording::CameraEntry* camera = nullptr;
  std::int64_t instant = 0;
  std::int64_t video_frame = 0;
};

struct PersonPixels {
  double all = 0, missing = 0;
  double limb = 0, limb_found = 0;
};

struct FrameResult {
  base::Status status;
  bool delivered = false;
  MatteScore score;
  FalseForeground empty;
  std::vector<PersonPixels> people;  // in the order of the truth's
};

// 255 where the true camera sees turf of the pitch or 4 m round it, in cells of 8 pixels.
image::Image<std::uint8_t> turf_of(const geometry::CameraEstimate& camera,
                                   const pitch::PitchModel& pitch) {
  constexpr int kCell = 8;
  constexpr double kRound = 4;  // metres
  const double half_x = pitch.length_m / 2 + pitch.in_goal_m + kRound;
  const double half_y = pitch.width_m / 2 + kRound;
  image::Image<std::uint8_t> turf(camera.model.width, camera.model.height);
  const Eigen::Vector3d eye = geometry::position_in_world(camera);
  for (int y0 = 0; y0 < turf.height(); y0 += kCell) {
    for (int x0 = 0; x0 < turf.width(); x0 += kCell) {
      const Eigen::Vector2d centre(x0 + (kCell - 1) / 2.0, y0 + (kCell - 1) / 2.0);
      const auto hit = pitch::intersect_turf(pitch, eye, geometry::ray_in_world(camera, centre));
      if (!hit || std::abs(hit->x()) > half_x || std::abs(hit->y()) > half_y) continue;
      for (int y = y0; y < std::min(y0 + kCell, turf.height()); ++y) {
        std::fill(turf.row(y) + x0, turf.row(y) + std::min(x0 + kCell, turf.width()),
                  std::uint8_t{255});
      }
    }
  }
  return turf;
}

FrameResult compare(const Context& context, const FrameTask& task) {
  FrameResult result;
  const base::CameraId& id = task.camera->id;
  const auto path = numbered(context.options.exports / "mattes" / id.value, task.instant, ".png");
  if (!is_there(path)) return result;
  const auto truth = context.truth.matte(id, task.video_frame);
  const auto found = truth ? read_grey_png(path) : truth;
  if (!found) {
    result.status = base::fail(found.error());
    return result;
  }
  if (found->width() != truth->width() || found->height() != truth->height()) {
    result.status = base::fail(base::ErrorKind::kFormat, path.string(),
                               fmt::format("is {} x {}, the truth {} x {}", found->width(),
                                           found->height(), truth->width(), truth->height()),
                               "export the mattes of a session of this recording");
    return result;
  }
  result.delivered = true;
  add_matte(result.score, *truth, *found);
  const auto camera = context.truth.camera(id, task.video_frame);
  if (!camera || camera->model.width != truth->width() || camera->model.height != truth->height()) {
    return result;
  }
  result.empty = false_foreground(*truth, *found, turf_of(*camera, context.pitch));
  const std::vector<TruePerson>& people = context.truth.people(task.instant);
  const std::vector<TrueJoint>& joints = context.truth.joints(task.instant);
  result.people.resize(people.size());
  const auto owner = body_map(*truth, *camera, people, joints);
  const auto limbs = limb_map(*truth, *camera, people, joints);
  for (std::size_t i = 0; i < truth->size(); ++i) {
    const bool there = found->data()[i] >= kForeground;
    if (const std::uint8_t p = owner.data()[i]; p != kNobody) {
      ++result.people[p].all;
      result.people[p].missing += !there;
    }
    if (const std::uint8_t p = limbs.data()[i]; p != kNobody) {
      ++result.people[p].limb;
      result.people[p].limb_found += there;
    }
  }
  return result;
}

void add_result(const Context& context, const FrameTask& task, const FrameResult& result,
                SeriesBook& book) {
  const std::string& id = task.camera->id.value;
  const std::int64_t frame = task.instant;
  book.add(kDelivered, id, {frame, result.delivered ? 100.0 : 0.0});
  if (!result.delivered) return;
  const MatteScore& s = result.score;
  const double boundary = s.true_boundary + s.found_boundary;
  book.add(kBoundary, id, {frame, s.mean_boundary_px(), boundary});
  book.add(kBoundaryF, id, {frame, 100 * s.boundary_f(), boundary});
  book.add(kMissing, id, {frame, 100 * s.missing_share(), s.true_px});
  book.add(kExtra, id, {frame, 100 * s.extra_share(), s.true_px});
  book.add(kAlpha, id, {frame, 100 * s.mean_alpha_error(), s.alpha_px});
  book.add(kIou, id, {frame, 100 * s.iou(), s.true_px + s.found_px - s.both_px});
  if (result.empty.turf_px > 0) {
    book.add(kFalse, id,
             {frame, 1e6 * result.empty.found_px / result.empty.turf_px, result.empty.turf_px});
  }
  double limb = 0;
  double limb_found = 0;
  const std::vector<TruePerson>& people = context.truth.people(frame);
  for (std::size_t p = 0; p < result.people.size(); ++p) {
    const PersonPixels& pixels = result.people[p];
    limb += pixels.limb;
    limb_found += pixels.limb_found;
    if (pixels.all > 0) {
      book.add_person(kMissingOf, people[p].id,
                      {frame, 100 * pixels.missing / pixels.all, pixels.all});
    }
    if (pixels.limb > 0) {
      book.add_person(kLimbsOf, people[p].id,
                      {frame, 100 * pixels.limb_found / pixels.limb, pixels.limb});
    }
  }
  if (limb > 0) book.add(kLimbs, id, {frame, 100 * limb_found / limb, limb});
}

}  // namespace

double MatteScore::iou() const {
  const double any = true_px + found_px - both_px;
  return any > 0 ? both_px / any : 1;
}
double MatteScore::missing_share() const { return ratio(true_px - both_px, true_px); }
double MatteScore::extra_share() const { return ratio(found_px - both_px, true_px); }
double MatteScore::mean_alpha_error() const { return ratio(alpha_error, alpha_px); }
double MatteScore::mean_boundary_px() const {
  return ratio(true_distance_px + found_distance_px, true_boundary + found_boundary);
}
double MatteScore::boundary_f() const {
  if (true_boundary + found_boundary <= 0) return 1;
  const double precision = ratio(found_near, found_boundary);
  const double recall = ratio(true_near, true_boundary);
  return ratio(2 * precision * recall, precision + recall);
}

void add_matte(MatteScore& score, const image::Image<std::uint8_t>& truth,
               const image::Image<std::uint8_t>& found) {
  ++score.frames;
  int x0 = truth.width(), y0 = truth.height(), x1 = -1, y1 = -1;
  for (int y = 0; y < truth.height(); ++y) {
    for (int x = 0; x < truth.width(); ++x) {
      const int t = truth(x, y);
      const int f = found(x, y);
      if (t == 0 && f == 0) continue;
      score.true_px += t >= kForeground;
      score.found_px += f >= kForeground;
      score.both_px += t >= kForeground && f >= kForeground;
      score.alpha_error += std::abs(t - f) / 255.0;
      ++score.alpha_px;
      x0 = std::min(x0, x);
      x1 = std::max(x1, x);
      y0 = std::min(y0, y);
      y1 = std::max(y1, y);
    }
  }
  if (x1 < 0) return;
  // One pixel more, so that what ends inside the picture has a boundary.
  const cv::Rect box =
      (cv::Rect(x0, y0, x1 - x0 + 1, y1 - y0 + 1) + cv::Size(2, 2) - cv::Point(1, 1)) &
      cv::Rect(0, 0, truth.width(), truth.height());
  const cv::Mat a = boundary_of(mat_of(truth)(box) >= kForeground);
  const cv::Mat b = boundary_of(mat_of(found)(box) >= kForeground);
  const Distances of_truth = distances(a, b);
  const Distances of_found = distances(b, a);
  score.true_boundary += of_truth.count;
  score.true_distance_px += of_truth.sum;
  score.true_near += of_truth.near;
  score.found_boundary += of_found.count;
  score.found_distance_px += of_found.sum;
  score.found_near += of_found.near;
}

FalseForeground false_foreground(const image::Image<std::uint8_t>& truth,
                                 const image::Image<std::uint8_t>& found,
                                 const image::Image<std::uint8_t>& turf) {
  constexpr int kAway = 10;
  cv::Mat taken;
  const cv::Mat square = cv::getStructuringElement(cv::MORPH_RECT, {2 * kAway + 1, 2 * kAway + 1});
  cv::dilate(mat_of(truth), taken, square);
  FalseForeground out;
  for (int y = 0; y < truth.height(); ++y) {
    const std::uint8_t* near = taken.ptr<std::uint8_t>(y);
    const std::uint8_t* is = found.row(y);
    const std::uint8_t* ground = turf.row(y);
    int empty = 0;
    int wrong = 0;
    for (int x = 0; x < truth.width(); ++x) {
      const bool counts = near[x] == 0 && ground[x] != 0;
      empty += counts;
      wrong += counts && is[x] >= kForeground;
    }
    out.turf_px += empty;
    out.found_px += wrong;
  }
  return out;
}

base::Status score_mattes(const Context& context, SeriesBook& book, Remarks& remarks) {
  std::vector<FrameTask> tasks;
  for (const recording::CameraEntry& entry : context.recording.cameras) {
    const std::string& id = entry.id.value;
    const std::vector<std::int64_t> frames = context.truth.matte_frames(entry.id);
    if (frames.empty()) {
      remarks.not_scored.push_back(fmt::format("matte {}: the truth has none", id));
      continue;
    }
    const auto folder = context.options.exports / "mattes" / id;
    if (!is_there(folder)) {
      remarks.not_scored.push_back(fmt::format("matte {}: no {}", id, folder.string()));
      continue;
    }
    std::vector<std::int64_t> instants = context.clocks.instants(entry.id, frames.back());
    std::erase_if(instants, [&](std::int64_t instant) {
      const auto frame = context.clocks.video_frame(entry.id, instant);
      return !frame || !std::binary_search(frames.begin(), frames.end(), *frame);
    });
    for (const std::int64_t instant : spread(instants, context.options.most_mattes)) {
      tasks.push_back({&entry, instant, *context.clocks.video_frame(entry.id, instant)});
    }
  }
  if (!tasks.empty() && !context.truth.has_joints()) {
    remarks.not_scored.push_back("limb recall: the truth has no joints.csv");
  }
  std::vector<FrameResult> results(tasks.size());
  tbb::parallel_for(std::size_t{0}, tasks.size(),
                    [&](std::size_t i) { results[i] = compare(context, tasks[i]); });
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    if (!results[i].status) return base::fail(results[i].status.error());
    add_result(context, tasks[i], results[i], book);
  }
  return {};
}

}  // namespace touchline::score
