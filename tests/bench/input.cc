#include "tests/bench/input.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <memory>
#include <span>
#include <utility>

#include "edge/compensate/compensator.h"
#include "edge/compensate/detail_estimator.h"
#include "edge/edge_config.h"
#include "edge/encode/assemble.h"
#include "edge/plate/plate_builder.h"
#include "shared/recording/video_reader.h"
#include "tests/bench/bench.h"
#include "tools/score/oracle.h"
#include "tools/score/truth.h"

namespace touchline::bench {

namespace {

int frame_limit() {
  const char* named = std::getenv("TOUCHLINE_BENCH_FRAMES");
  const int wanted = named != nullptr ? std::atoi(named) : 10;
  return std::max(1, wanted);
}

const score::Truth& truth() {
  static const score::Truth opened = must(score::Truth::open(the_recording()));
  return opened;
}

std::uint32_t mix(std::uint64_t seed) {
  seed ^= seed >> 33;
  seed *= 0xff51afd7ed558ccdu;
  seed ^= seed >> 33;
  seed *= 0xc4ceb9fe1a85ec53u;
  return static_cast<std::uint32_t>(seed >> 32);
}

// Sample (x, y) lies at (x / 2 + shift_x, y / 2 + shift_y) of `in`; `noise` is the half width of
// its triangular distribution.
template <typename T>
image::Image<T> twice(const image::Image<T>& in, double shift_x, double shift_y, double noise,
                      std::uint64_t seed, double most) {
  image::Image<T> out(2 * in.width(), 2 * in.height());
  for (int y = 0; y < out.height(); ++y) {
    const double v = std::clamp(0.5 * y + shift_y, 0.0, in.height() - 1.0);
    const int y0 = std::min(static_cast<int>(v), in.height() - 2);
    const double fy = v - y0;
    const T* a = in.row(y0);
    const T* b = in.row(y0 + 1);
    for (int x = 0; x < out.width(); ++x) {
      const double u = std::clamp(0.5 * x + shift_x, 0.0, in.width() - 1.0);
      const int x0 = std::min(static_cast<int>(u), in.width() - 2);
      const double fx = u - x0;
      double value =
          (1 - fy) * ((1 - fx) * a[x0] + fx * a[x0 + 1]) + fy * ((1 - fx) * b[x0] + fx * b[x0 + 1]);
      if (noise > 0) {
        const std::uint32_t bits =
            mix(seed + static_cast<std::uint64_t>(y) * 8192u + static_cast<std::uint64_t>(x));
        value += noise * (static_cast<double>(bits & 0xffffu) - static_cast<double>(bits >> 16)) /
                 65536.0;
      }
      out(x, y) = static_cast<T>(std::clamp(value + 0.5, 0.0, most));
    }
  }
  return out;
}

CameraFrames load(const recording::CameraEntry& entry) {
  if (entry.width != 1920 || entry.height != 1080) {
    give_up({base::ErrorKind::kUnsupported, entry.video.string(),
             "the benches are stated for pictures of 1920x1080",
             "name another recording in TOUCHLINE_RECORDING"});
  }
  CameraFrames out;
  auto reader = must(recording::VideoReader::open(entry, the_recording(), 1));
  while (static_cast<int>(out.frames.size()) < frame_limit()) {
    auto frame = must(reader.next());
    if (!frame) break;
    const auto k = static_cast<std::int64_t>(out.frames.size());
    const auto camera = truth().camera(entry.id, k);
    if (!camera) break;
    out.truth.push_back(*camera);
    out.mattes.push_back(must(truth().matte(entry.id, k)));
    out.frames.push_back(std::make_shared<const image::Frame>(std::move(*frame)));
  }
  compensate::DetailEstimator estimator;
  for (std::size_t i = 0; i < std::min<std::size_t>(out.frames.size(), 6); ++i) {
    estimator.add(out.frames[i]->luma());
  }
  out.detail = estimator.estimate();
  out.raw.assign(out.frames.begin(),
                 out.frames.begin() + std::min<std::ptrdiff_t>(10, std::ssize(out.frames)));
  const compensate::Compensator undo(out.detail);
  for (image::FramePtr& frame : out.frames) {
    frame = std::make_shared<const image::Frame>(undo.apply(*frame));
  }
  return out;
}

const CameraFrames& loaded(const recording::CameraEntry& entry) {
  static std::map<base::CameraId, CameraFrames> cache;
  const auto found = cache.find(entry.id);
  if (found != cache.end()) return found->second;
  return cache.emplace(entry.id, load(entry)).first->second;
}

codec::CameraView perfect_view(const recording::CameraEntry& entry, Size size) {
  const CameraFrames& camera = loaded(entry);
  const bool large = size == Size::k2160;
  const image::Frame frame = large ? doubled(*camera.frames[0]) : *camera.frames[0];
  const auto estimate = large ? scaled(camera.truth[0], 2) : camera.truth[0];
  const auto alpha = large ? doubled(camera.mattes[0]) : camera.mattes[0];
  return encode::assemble(frame, estimate,
                          score::oracle_matte(alpha, estimate, the_pitch(), large ? 5 : 2.5),
                          the_pitch(), {});
}

image::PlateSnapshot learn(const recording::CameraEntry& entry, const CameraFrames& camera,
                           const Survey* surveyed) {
  plate::PlateBuilder builder(the_pitch(), geometry::position_in_world(camera.truth[0]),
                              1 / camera.truth[0].model.fx);
  if (surveyed != nullptr && entry.role == recording::Role::kMatch) {
    for (std::size_t i = 0; i < surveyed->stills.size(); ++i) {
      builder.seed(surveyed->stills[i], surveyed->result.stills[i]);
    }
  }
  for (std::size_t i = 0; i < camera.frames.size(); ++i) {
    builder.add(*camera.frames[i], camera.truth[i]);
  }
  return *builder.snapshot(true);
}

}  // namespace

std::string name(Size size) { return size == Size::k1080 ? "1080p" : "2160p"; }

const recording::Recording& the_recording() {
  static const recording::Recording loaded = [] {
    const char* named = std::getenv("TOUCHLINE_RECORDING");
    return must(recording::load_recording(named != nullptr ? named : "tests/data/sample"));
  }();
  return loaded;
}

const pitch::PitchModel& the_pitch() {
  static const pitch::PitchModel made =
      must(pitch::make_pitch(the_recording().sport, the_recording().sizes));
  return made;
}

const recording::CameraEntry& first_camera(recording::Role role) {
  for (const recording::CameraEntry& entry : the_recording().cameras) {
    if (entry.role == role) return entry;
  }
  give_up({base::ErrorKind::kNotFound, the_recording().name,
           "no camera of role '" + std::string(recording::name(role)) + "'",
           "name another recording in TOUCHLINE_RECORDING"});
}

const CameraFrames& camera_frames(recording::Role role, Size size) {
  const recording::CameraEntry& entry = first_camera(role);
  const CameraFrames& small = loaded(entry);
  if (size == Size::k1080) return small;
  static std::map<base::CameraId, CameraFrames> cache;
  const auto found = cache.find(entry.id);
  if (found != cache.end()) return found->second;
  CameraFrames large;
  large.detail = small.detail;
  for (const auto& frame : small.raw) {
    large.raw.push_back(std::make_shared<const image::Frame>(doubled(*frame)));
  }
  for (std::size_t i = 0; i < small.frames.size(); ++i) {
    large.frames.push_back(std::make_shared<const image::Frame>(doubled(*small.frames[i])));
    large.truth.push_back(scaled(small.truth[i], 2));
    large.mattes.push_back(doubled(small.mattes[i]));
  }
  return cache.emplace(entry.id, std::move(large)).first->second;
}

const Survey& survey(recording::Role role) {
  static std::map<recording::Role, Survey> cache;
  const auto found = cache.find(role);
  if (found != cache.end()) return found->second;
  const recording::CameraEntry& entry = first_camera(role);
  const edge::ChainSetup setup = must(edge::chain_setup(the_recording(), entry.id));
  Survey out;
  if (role == recording::Role::kFixed) {
    std::vector<image::Frame> frames;
    for (const auto& frame : loaded(entry).frames) {
      if (frames.size() < 6) frames.push_back(*frame);
    }
    out.result = must(calibrate::survey_fixed(frames, the_pitch(), setup.side, {}));
  } else {
    out.stills = std::move(edge::load_stills(entry).frames);
    out.result = must(edge::survey_mount(setup, {}, out.stills));
  }
  return cache.emplace(role, std::move(out)).first->second;
}

geometry::Mount mount(recording::Role role, Size size) {
  geometry::Mount out = survey(role).result.mount;
  if (size == Size::k1080) return out;
  out.width *= 2;
  out.height *= 2;
  out.cx = 2 * out.cx + 0.5;
  out.cy = 2 * out.cy + 0.5;
  for (geometry::LensKnot& knot : out.lens) knot.focal_px *= 2;
  out.covariance.block<7, 2>(0, 5) *= 2;
  out.covariance.block<2, 7>(5, 0) *= 2;
  return out;
}

const image::PlateSnapshot& plate(recording::Role role, Size size) {
  static std::map<std::pair<recording::Role, Size>, image::PlateSnapshot> cache;
  const auto key = std::pair(role, size);
  const auto found = cache.find(key);
  if (found != cache.end()) return found->second;
  const bool head = role == recording::Role::kMatch && !smoke();
  return cache
      .emplace(key,
               learn(first_camera(role), camera_frames(role, size), head ? &survey(role) : nullptr))
      .first->second;
}

std::span<const recording::CameraEntry> cameras() {
  const std::span<const recording::CameraEntry> all(the_recording().cameras);
  return smoke() ? all.first(std::min<std::size_t>(2, all.size())) : all;
}

const std::vector<codec::CameraView>& instant(Size size) {
  static std::map<Size, std::vector<codec::CameraView>> cache;
  auto& views = cache[size];
  if (!views.empty()) return views;
  for (const recording::CameraEntry& entry : cameras()) {
    views.push_back(perfect_view(entry, size));
  }
  return views;
}

const std::map<base::CameraId, image::PlateSnapshot>& plates() {
  static std::map<base::CameraId, image::PlateSnapshot> cache;
  if (!cache.empty()) return cache;
  for (const recording::CameraEntry& entry : cameras()) {
    cache[entry.id] = learn(entry, loaded(entry), nullptr);
  }
  return cache;
}

geometry::CameraEstimate virtual_camera(Size size) {
  if (truth().virtual_cameras().empty()) {
    give_up({base::ErrorKind::kNotFound, the_recording().name, "its truth has no virtual camera",
             "name another recording in TOUCHLINE_RECORDING"});
  }
  const auto camera = truth().camera(truth().virtual_cameras().front(), 0);
  if (!camera) {
    give_up({base::ErrorKind::kNotFound, the_recording().name, "its virtual camera has no frame 0",
             ""});
  }
  const double lines = smoke() ? 135 : size == Size::k1080 ? 1080 : 2160;
  return scaled(*camera, lines / camera->model.height);
}

geometry::CameraEstimate scaled(geometry::CameraEstimate camera, double factor) {
  geometry::CameraModel& model = camera.model;
  model.width = static_cast<int>(std::lround(model.width * factor));
  model.height = static_cast<int>(std::lround(model.height * factor));
  model.fx *= factor;
  model.fy *= factor;
  model.cx = (model.cx + 0.5) * factor - 0.5;
  model.cy = (model.cy + 0.5) * factor - 0.5;
  return camera;
}

image::Frame doubled(const image::Frame& frame) {
  image::Frame out;
  out.id = frame.id;
  out.stamp = frame.stamp;
  out.format = frame.format;
  out.colour = frame.colour;
  out.scan = frame.scan;
  const image::ChromaShift shift = image::chroma_shift(frame.format);
  for (std::size_t plane = 0; plane < 3; ++plane) {
    // Chroma sample i is co-sited with luma sample 2 i.
    const double x = plane > 0 && shift.x > 0 ? -0.125 : -0.25;
    const double y = plane > 0 && shift.y > 0 ? -0.125 : -0.25;
    out.planes[plane] =
        twice(frame.planes[plane], x, y, 5.0, (frame.id.sequence * 3 + plane) * 100'000'000u, 1023);
  }
  return out;
}

image::Image<std::uint8_t> doubled(const image::Image<std::uint8_t>& mask) {
  return twice(mask, -0.25, -0.25, 0, 0, 255);
}

}  // namespace touchline::bench
