#include "tools/score/oracle.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "shared/image/colour.h"
#include "tools/score/frame_clocks.h"

namespace touchline::score {

namespace {

// Pixels of a segment in the world, in pieces short enough for the lens' curvature.
std::vector<cv::Point> project_segment(const geometry::CameraEstimate& camera,
                                       const Eigen::Vector3d& start, const Eigen::Vector3d& end) {
  constexpr int kPieces = 16;
  constexpr double kSubPixels = 16;
  std::vector<cv::Point> points;
  for (int i = 0; i <= kPieces; ++i) {
    const auto pixel = geometry::project(camera, start + (end - start) * (double(i) / kPieces));
    if (!pixel || pixel->cwiseAbs().maxCoeff() > 1e5) continue;
    points.emplace_back(static_cast<int>(std::lround(pixel->x() * kSubPixels)),
                        static_cast<int>(std::lround(pixel->y() * kSubPixels)));
  }
  return points;
}

image::Rect grown(const cv::Rect& box, int margin, int width, int height) {
  const int x0 = std::max(box.x - margin, 0);
  const int y0 = std::max(box.y - margin, 0);
  const int x1 = std::min(box.x + box.width + margin, width);
  const int y1 = std::min(box.y + box.height + margin, height);
  return {x0, y0, x1 - x0, y1 - y0};
}

}  // namespace

image::Matte oracle_matte(const image::Image<std::uint8_t>& alpha,
                          const geometry::CameraEstimate& camera, const pitch::PitchModel& pitch,
                          double occluder_margin_px) {
  constexpr int kShift = 4;  // cv's fixed-point pixels: 1/16
  image::Matte matte;
  matte.region = {0, 0, alpha.width(), alpha.height()};
  matte.alpha = alpha;
  matte.occluders = image::Image<std::uint8_t>(alpha.width(), alpha.height());
  cv::Mat mask(alpha.height(), alpha.width(), CV_8UC1, matte.occluders.data());
  for (const pitch::Bar& bar : pitch.bars) {
    const std::vector<cv::Point> line = project_segment(camera, bar.start, bar.end);
    if (line.size() < 2) continue;
    const double distance = (camera.cam_from_world * ((bar.start + bar.end) / 2)).z();
    const double thickness = camera.model.fx * bar.diameter / distance + 2 * occluder_margin_px;
    cv::polylines(mask, std::vector<std::vector<cv::Point>>{line}, false, cv::Scalar(255),
                  std::max(1, static_cast<int>(std::ceil(thickness))), cv::LINE_8, kShift);
  }
  for (const pitch::NetPanel& panel : pitch.nets) {
    std::vector<cv::Point> outline;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::vector<cv::Point> side =
          project_segment(camera, panel.corners[i], panel.corners[(i + 1) % 4]);
      outline.insert(outline.end(), side.begin(), side.end());
    }
    if (outline.size() < 3) continue;
    cv::fillPoly(mask, std::vector<std::vector<cv::Point>>{outline}, cv::Scalar(255), cv::LINE_8,
                 kShift);
  }
  matte.unknown = matte.occluders;
  return matte;
}

std::vector<codec::TextureTile> cut_tiles(const image::Frame& frame, const image::Matte& matte,
                                          int margin_px) {
  const cv::Mat alpha(matte.alpha.height(), matte.alpha.width(), CV_8UC1,
                      const_cast<std::uint8_t*>(matte.alpha.data()));
  cv::Mat labels;
  cv::Mat stats;
  cv::Mat centres;
  const int count = cv::connectedComponentsWithStats(alpha > 0, labels, stats, centres);
  std::vector<image::Rect> places;
  for (int i = 1; i < count; ++i) {
    const cv::Rect box(stats.at<int>(i, cv::CC_STAT_LEFT), stats.at<int>(i, cv::CC_STAT_TOP),
                       stats.at<int>(i, cv::CC_STAT_WIDTH), stats.at<int>(i, cv::CC_STAT_HEIGHT));
    places.push_back(grown(box, margin_px, matte.alpha.width(), matte.alpha.height()));
  }
  std::vector<codec::TextureTile> tiles;
  for (const image::Rect& place : places) {
    const bool inside_another =
        std::any_of(places.begin(), places.end(), [&](const image::Rect& other) {
          return other != place && other.x <= place.x && other.y <= place.y &&
                 other.x + other.width >= place.x + place.width &&
                 other.y + other.height >= place.y + place.height;
        });
    if (inside_another) continue;
    tiles.push_back({place, image::to_rgb(frame, place)});
  }
  return tiles;
}

struct Oracle::Impl {
  struct Source {
    recording::CameraEntry entry;
    std::optional<recording::VideoReader> video;
    std::int64_t read = 0;  // frames of the video so far; the last one is `frame`
    std::optional<image::Frame> frame;
  };
  recording::Recording recording;
  Truth truth;
  OracleOptions options;
  pitch::PitchModel pitch;
  FrameClocks clocks;
  std::vector<Source> sources;
  std::int64_t frame = 0;
};

Oracle::Oracle(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Oracle::Oracle(Oracle&&) noexcept = default;
Oracle& Oracle::operator=(Oracle&&) noexcept = default;
Oracle::~Oracle() = default;

base::Result<Oracle> Oracle::open(const recording::Recording& recording, const Truth& truth,
                                  const OracleOptions& options) {
  auto pitch = pitch::make_pitch(recording.sport, recording.sizes);
  if (!pitch) return base::fail(pitch.error());
  auto impl = std::make_unique<Impl>();
  impl->recording = recording;
  impl->truth = truth;
  impl->options = options;
  impl->pitch = std::move(*pitch);
  auto clocks = FrameClocks::open(recording);
  if (!clocks) return base::fail(clocks.error());
  impl->clocks = std::move(*clocks);
  std::vector<base::CameraId> wanted = options.cameras;
  if (wanted.empty()) {
    for (const recording::CameraEntry& entry : recording.cameras) wanted.push_back(entry.id);
  }
  for (const base::CameraId& id : wanted) {
    const auto entry = std::find_if(recording.cameras.begin(), recording.cameras.end(),
                                    [&](const recording::CameraEntry& e) { return e.id == id; });
    if (entry == recording.cameras.end()) {
      return base::fail(base::ErrorKind::kArgument, recording.root.string(),
                        fmt::format("has no camera '{}'", id.value));
    }
    Impl::Source source;
    source.entry = *entry;
    if (options.tiles) {
      auto video = recording::VideoReader::open(*entry, recording, 0, {.thread_count = 2});
      if (!video) return base::fail(video.error());
      source.video.emplace(std::move(*video));
    }
    impl->sources.push_back(std::move(source));
  }
  return Oracle(std::move(impl));
}

const pitch::PitchModel& Oracle::pitch() const { return impl_->pitch; }
std::int64_t Oracle::next_frame() const { return impl_->frame; }

base::Result<std::optional<std::vector<codec::CameraView>>> Oracle::next() {
  const std::int64_t index = impl_->frame;
  std::vector<codec::CameraView> views;
  bool any = false;
  for (Impl::Source& source : impl_->sources) {
    codec::CameraView view;
    view.id = {source.entry.id, 0, static_cast<std::uint64_t>(index)};
    view.stamp.media_time = base::frame_time(impl_->recording.start, impl_->recording.rate, index);
    view.stamp.domain = base::ClockDomain::kRecording;
    const auto video_frame = impl_->clocks.video_frame(source.entry.id, index);
    while (source.video && video_frame && source.read <= *video_frame) {
      auto read = source.video->next();
      if (!read) return base::fail(read.error());
      source.frame = std::move(*read);
      if (!source.frame) break;  // the video has ended
      ++source.read;
    }
    view.estimate.model.width = source.entry.width;
    view.estimate.model.height = source.entry.height;
    const bool has_frame =
        video_frame && (!source.video || (source.frame && source.read == *video_frame + 1));
    const auto camera =
        has_frame ? impl_->truth.camera(source.entry.id, *video_frame) : std::nullopt;
    if (camera) {
      any = true;
      view.estimate = *camera;
      if (source.video) view.stamp = source.frame->stamp;
      auto alpha = impl_->truth.matte(source.entry.id, *video_frame);
      if (alpha) {
        view.matte = oracle_matte(*alpha, *camera, impl_->pitch, impl_->options.occluder_margin_px);
        if (source.video) {
          const auto& treat = impl_->options.treat;
          view.tiles = cut_tiles(treat ? treat(source.entry.id, *source.frame) : *source.frame,
                                 *view.matte, impl_->options.tile_margin_px);
        }
      } else if (alpha.error().kind != base::ErrorKind::kNotFound) {
        return base::fail(alpha.error());
      }
    }
    views.push_back(std::move(view));
  }
  if (!any) return std::nullopt;
  ++impl_->frame;
  return views;
}

void Oracle::skip_to(std::int64_t frame) { impl_->frame = std::max(impl_->frame, frame); }

}  // namespace touchline::score
