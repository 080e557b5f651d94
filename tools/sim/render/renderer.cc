#include "tools/sim/render/renderer.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <mutex>
#include <utility>

#include "tools/sim/render/blocks_internal.h"
#include "tools/sim/render/lens_internal.h"
#include "tools/sim/render/moment_internal.h"
#include "tools/sim/render/net_internal.h"
#include "tools/sim/render/outline_internal.h"
#include "tools/sim/render/rain_internal.h"
#include "tools/sim/render/shade_internal.h"
#include "tools/sim/world/noise.h"

namespace touchline::sim::render {
namespace {

constexpr int kTile = 32;  // pixels
constexpr int kBlock = 8;
constexpr int kMostSamples = 64;
constexpr float kCrowdSmear = 6;     // pixels between two samples that leave no second picture
constexpr float kLongestSmear = 24;  // pixels of turf that one sample takes in
constexpr std::size_t kMoments = 3;  // kept for cameras of the same time

// Sample positions of one count, with the camera at the time of each.
struct Pattern {
  std::vector<SamplePoint> points;
  std::vector<SampleCamera> cameras;
  float size = 1;
};

Pattern make_pattern(int count, const Exposure& exposure, bool moving, const LensTable* still,
                     std::vector<LensTable>& lenses) {
  Pattern pattern;
  pattern.points = sample_points(count);
  pattern.size = 1 / std::sqrt(static_cast<float>(count));
  for (const SamplePoint& point : pattern.points) {
    const double time = moving ? static_cast<double>(point.time) : 0.0;
    const geometry::CameraModel model = model_at(exposure, time);
    const geometry::Rigid3 pose = pose_at(exposure, time);
    SampleCamera camera;
    camera.cx = static_cast<float>(model.cx);
    camera.cy = static_cast<float>(model.cy);
    camera.per_fx = static_cast<float>(1 / model.fx);
    camera.per_fy = static_cast<float>(1 / model.fy);
    camera.world_from_cam = pose.rotation.conjugate().toRotationMatrix().cast<float>();
    camera.origin = geometry::origin(pose).cast<float>();
    if (still) {
      camera.lens = still;
    } else {
      lenses.emplace_back(model);
      camera.lens = &lenses.back();
    }
    pattern.cameras.push_back(camera);
  }
  return pattern;
}

// What has been found of each pixel.
struct Buffers {
  int width, height;
  std::vector<std::array<float, 4>> sums;  // colour and matte, means
  std::vector<std::uint32_t> kinds;        // of the first sample
  std::vector<std::uint8_t> taken;         // samples
  std::vector<std::uint8_t> traits;
};
constexpr std::uint8_t kMixed = 1, kFigure = 2, kStand = 4, kDetail = 8;

// Which stands hold the camera: those are not in its picture.
std::uint32_t visible_mask(const world::Structure& structure, const Exposure& exposure) {
  std::uint32_t mask = ~0u;
  for (int side = 0; side < world::kSides; ++side) {
    const world::Tier& tier = structure.stands[static_cast<std::size_t>(side)];
    if (!tier.present) continue;
    for (const ShutterPose* pose : {&exposure.open, &exposure.close}) {
      const Eigen::Vector3f from = geometry::origin(pose->cam_from_world).cast<float>() - tier.foot;
      const float w = from.dot(tier.outward), s = std::abs(from.dot(tier.along));
      if (w < -0.5f || s > tier.half_length + std::max(w, 0.0f)) continue;
      const float cover =
          world::kTierWall + world::kTierCover +
          world::kRowRise * std::clamp(w / world::kRowDepth, 0.0f, static_cast<float>(tier.rows));
      if (from.z() < cover + 1.0f || w > tier.depth) mask &= ~world::tier_mask(side);
      if (w > tier.roof_front - 2) mask &= ~world::roof_mask(side);
    }
  }
  return mask;
}

class Frame {
 public:
  Frame(const Ground& ground, const Moment& moment, const Nets& nets, const Exposure& exposure,
        const RenderOptions& options)
      : exposure_(exposure),
        options_(options),
        moving_(moves(exposure)),
        shader_(ground, moment, nets, 0.5 * (exposure.open_s + exposure.close_s),
                visible_mask(ground.world().structure, exposure), options.shadows) {
    const geometry::CameraModel& model = exposure.open.model;
    buffers_.width = model.width;
    buffers_.height = model.height;
    const std::size_t pixels =
        static_cast<std::size_t>(model.width) * static_cast<std::size_t>(model.height);
    buffers_.sums.resize(pixels);
    buffers_.kinds.resize(pixels);
    buffers_.taken.resize(pixels);
    buffers_.traits.resize(pixels);
    lenses_.reserve(2 * kMostSamples + 64);
    if (model == exposure.close.model) still_ = std::make_unique<LensTable>(model);
    edge_ = std::clamp(std::bit_ceil(static_cast<unsigned>(std::max(options.edge_samples, 4))), 4u,
                       static_cast<unsigned>(kMostSamples));
    for (const int count : {1, 2, 4, 8, 16, 32, 64}) {
      if (count > static_cast<int>(edge_)) continue;
      patterns_.emplace_back(count, make_pattern(count, exposure, moving_, still_.get(), lenses_));
    }
    columns_ = (model.width + kTile - 1) / kTile;
    rows_ = (model.height + kTile - 1) / kTile;
    across_ = (model.width + kBlock - 1) / kBlock;
    const int down = (model.height + kBlock - 1) / kBlock;
    net_bits_ = nets.by_tile(exposure, kBlock, across_, down);
    outlines_ = find_outlines(exposure, moment, ground.world(), kBlock);
    solids_ = blocks_with_solids(exposure, ground, visible_mask(ground.world().structure, exposure),
                                 kBlock);
  }

  void first_pass() {
    tbb::parallel_for(0, columns_ * rows_, [&](int tile) { first_tile(tile); });
  }
  void second_pass() {
    // What a pixel needs depends on the first pass alone.
    wanted_.resize(buffers_.sums.size());
    tbb::parallel_for(0, rows_, [&](int row) {
      for (int y = row * kTile; y < std::min((row + 1) * kTile, buffers_.height); ++y) want_row(y);
    });
    tbb::parallel_for(0, columns_ * rows_, [&](int tile) { second_tile(tile); });
  }
  Picture picture() const {
    Picture out;
    out.radiance = image::Image<std::array<float, 3>>(buffers_.width, buffers_.height);
    out.matte = image::Image<std::uint8_t>(buffers_.width, buffers_.height);
    tbb::parallel_for(0, buffers_.height, [&](int y) {
      for (int x = 0; x < buffers_.width; ++x) {
        const auto& s = buffers_.sums[static_cast<std::size_t>(y * buffers_.width + x)];
        out.radiance(x, y) = {s[0], s[1], s[2]};
        out.matte(x, y) = static_cast<std::uint8_t>(255 * std::clamp(s[3], 0.0f, 1.0f) + 0.5f);
      }
    });
    return out;
  }
  const Shader& shader() const { return shader_; }

 private:
  const Pattern& pattern(int count) const {
    for (const auto& [n, p] : patterns_)
      if (n >= count) return p;
    return patterns_.back().second;
  }
  struct Rectangle {
    int x0, y0, x1, y1;
  };
  Rectangle rectangle(int tile) const {
    const int x = tile % columns_ * kTile, y = tile / columns_ * kTile;
    return {x, y, std::min(x + kTile, buffers_.width), std::min(y + kTile, buffers_.height)};
  }
  Eigen::Vector2f motion_of(const Rectangle& r) const {
    if (!moving_) return {0, 0};
    Eigen::Vector2f most(0, 0);
    for (const int x : {r.x0, r.x1 - 1})
      for (const int y : {r.y0, r.y1 - 1})
        most = most.cwiseMax(
            picture_motion(exposure_, {static_cast<double>(x), static_cast<double>(y)}));
    return most;
  }
  int least_samples(const Eigen::Vector2f& motion) const {
    const float longest = motion.maxCoeff();
    if (longest < 0.3f) return 1;
    return longest < 6 ? 4 : static_cast<int>(std::min(edge_, 16u));
  }

  // Collects the samples of a few pixels into packets.
  class Queue {
   public:
    Queue(Frame& frame, const Eigen::Vector2f& motion) : frame_(frame), motion_(motion) {}
    ~Queue() { flush(); }
    Queue(const Queue&) = delete;
    Queue& operator=(const Queue&) = delete;
    // All samples of one pixel; its earlier samples are forgotten.
    void add(int x, int y, int count) {
      const Pattern& p = frame_.pattern(count);
      const std::size_t pixel = static_cast<std::size_t>(y * frame_.buffers_.width + x);
      const std::size_t block = frame_.block(x, y);
      frame_.buffers_.sums[pixel] = {};
      frame_.buffers_.taken[pixel] = 0;
      frame_.buffers_.traits[pixel] = 0;
      for (std::size_t i = 0; i < p.points.size(); ++i) {
        Lane& lane = lanes_[static_cast<std::size_t>(used_)];
        lane.x = static_cast<float>(x) + p.points[i].x;
        lane.y = static_cast<float>(y) + p.points[i].y;
        lane.time = p.points[i].time;
        lane.camera = &p.cameras[i];
        lane.size = p.size;
        const float per = 1 / static_cast<float>(p.points.size());
        lane.smear_x = motion_.x() * per;
        lane.smear_y = motion_.y() * per;
        lane.nets = frame_.net_bits_[block];
        lane.solids = frame_.solids_[block] != 0;
        lane.figures = frame_.outlines_.tiles[block] != 0;
        lane.lone = p.points.size() < 4;
        pixels_[static_cast<std::size_t>(used_)] = pixel;
        weights_[static_cast<std::size_t>(used_)] = per;
        if (++used_ == kLanes) flush();
      }
    }
    void flush() {
      if (used_ == 0) return;
      std::array<Sample, kLanes> samples;
      frame_.shader_.trace(lanes_.data(), used_, samples.data());
      Buffers& b = frame_.buffers_;
      for (std::size_t i = 0; i < static_cast<std::size_t>(used_); ++i) {
        const Sample& s = samples[i];
        const std::size_t pixel = pixels_[i];
        for (std::size_t k = 0; k < 3; ++k) b.sums[pixel][k] += weights_[i] * s.colour[k];
        b.sums[pixel][3] += weights_[i] * s.matte;
        if (b.taken[pixel]++ == 0) b.kinds[pixel] = s.kind;
        if (s.detail) b.traits[pixel] |= kDetail;
        if (b.kinds[pixel] != s.kind) b.traits[pixel] |= kMixed;
        if (s.figure) b.traits[pixel] |= kFigure;
        if (s.stand) b.traits[pixel] |= kStand;
      }
      used_ = 0;
    }

   private:
    Frame& frame_;
    Eigen::Vector2f motion_;
    std::array<Lane, kLanes> lanes_;
    std::array<std::size_t, kLanes> pixels_{};
    std::array<float, kLanes> weights_{};
    int used_ = 0;
  };

  std::size_t block(int x, int y) const {
    return static_cast<std::size_t>(y / kBlock * across_ + x / kBlock);
  }

  void first_tile(int tile) {
    const Rectangle r = rectangle(tile);
    const Eigen::Vector2f motion = motion_of(r);
    const int least = least_samples(motion);
    const bool knows_turf = shader_.knows_turf() && motion.maxCoeff() < kLongestSmear;
    Queue queue(*this, motion);
    const std::vector<bool> stands = blocks_with_stands(r);
    const int still_crowd = std::clamp(options_.crowd_samples, 1, 4);
    const int crowd = least > 1 && motion.maxCoeff() < kCrowdSmear ? std::max(still_crowd, 2)
                                                                   : std::max(still_crowd, least);
    for (int y = r.y0; y < r.y1; y += kBlock)
      for (int x = r.x0; x < r.x1; x += kBlock) {
        const Rectangle inner{x, y, std::min(x + kBlock, r.x1), std::min(y + kBlock, r.y1)};
        const std::size_t at = block(x, y);
        const bool stand = stands[static_cast<std::size_t>((y - r.y0) / kBlock * (kTile / kBlock) +
                                                           (x - r.x0) / kBlock)];
        const int usual = stand ? crowd : least;
        if (knows_turf && !solids_[at] && !outlines_.tiles[at] && !net_bits_[at]) {
          turf_block(inner, motion, least, queue);
        } else {
          first_block(inner, least, usual, queue);
        }
      }
  }

  void first_block(const Rectangle& r, int least, int usual, Queue& queue) {
    // Four by two make coherent packets.
    for (int y = r.y0; y < r.y1; y += 2)
      for (int x = r.x0; x < r.x1; x += 4)
        for (int j = y; j < std::min(y + 2, r.y1); ++j)
          for (int i = x; i < std::min(x + 4, r.x1); ++i) {
            const bool thin = outlines_.thin[static_cast<std::size_t>(j * buffers_.width + i)] != 0;
            queue.add(i, j, thin ? std::max(least, 4) : usual);
          }
  }

  // A block with nothing before the turf.
  void turf_block(const Rectangle& r, const Eigen::Vector2f& motion, int least, Queue& queue) {
    static_assert(kBlock == kLanes);
    TurfRow row;
    row.camera = &pattern(1).cameras[0];
    row.x = static_cast<float>(r.x0);
    row.moving = least > 1;
    row.wide_x = 1 + motion.x();
    row.wide_y = 1 + motion.y();
    TurfPixels found;
    for (int y = r.y0; y < r.y1; ++y) {
      row.y = static_cast<float>(y);
      shader_.trace_turf(row, found);
      for (int x = r.x0; x < r.x1; ++x) {
        const auto lane = static_cast<std::size_t>(x - r.x0);
        const std::size_t pixel = static_cast<std::size_t>(y * buffers_.width + x);
        if (!(found.done >> lane & 1u)) {
          queue.add(x, y, least);
          continue;
        }
        buffers_.sums[pixel] = {found.red[lane], found.green[lane], found.blue[lane], 0.0f};
        buffers_.kinds[pixel] = found.kind(lane);
        buffers_.taken[pixel] = 1;
        buffers_.traits[pixel] = found.detail >> lane & 1u ? kDetail : 0;
      }
    }
  }

  // Whether the middle of each block of a tile shows seats: those take their samples at once.
  std::vector<bool> blocks_with_stands(const Rectangle& r) const {
    constexpr int kAcross = kTile / kBlock;
    std::vector<bool> found(kAcross * kAcross, false);
    bool any = false;
    for (int y = r.y0; y < r.y1; y += kBlock)
      for (int x = r.x0; x < r.x1; x += kBlock) any = any || solids_[block(x, y)] != 0;
    if (!any) return found;
    const Pattern& p = pattern(1);
    std::array<Lane, kLanes> lanes;
    for (int first = 0; first < kAcross * kAcross; first += kLanes) {
      for (int k = 0; k < kLanes; ++k) {
        Lane& lane = lanes[static_cast<std::size_t>(k)];
        lane.x = static_cast<float>(r.x0 + (first + k) % kAcross * kBlock) + 0.5f * kBlock;
        lane.y = static_cast<float>(r.y0 + (first + k) / kAcross * kBlock) + 0.5f * kBlock;
        lane.camera = &p.cameras[0];
        lane.figures = false;
      }
      const std::uint32_t bits = shader_.meets_stand(lanes.data(), kLanes);
      for (int k = 0; k < kLanes; ++k)
        found[static_cast<std::size_t>(first + k)] = (bits >> k) & 1u;
    }
    return found;
  }

  void want_row(int y) {
    const auto width = static_cast<std::size_t>(buffers_.width);
    const auto row = [&](int j) {
      return &buffers_
                  .kinds[static_cast<std::size_t>(std::clamp(j, 0, buffers_.height - 1)) * width];
    };
    const std::uint32_t *above = row(y - 1), *here = row(y), *under = row(y + 1);
    // Bits that differ among a pixel and those above and below it.
    std::vector<std::uint32_t> differ(width);
    for (std::size_t x = 0; x < width; ++x) differ[x] = (above[x] ^ here[x]) | (under[x] ^ here[x]);
    const std::uint8_t* traits = &buffers_.traits[static_cast<std::size_t>(y) * width];
    std::uint8_t* wanted = &wanted_[static_cast<std::size_t>(y) * width];
    for (std::size_t x = 0; x < width; ++x) {
      const std::size_t left = x > 0 ? x - 1 : x, right = x + 1 < width ? x + 1 : x;
      const std::uint32_t edge = differ[left] | differ[x] | differ[right] | (here[left] ^ here[x]) |
                                 (here[right] ^ here[x]) | traits[x];
      if (edge == 0) continue;
      wanted[x] = static_cast<std::uint8_t>(wanted_at(static_cast<int>(x), y));
    }
  }

  int wanted_at(int x, int y) const {
    const std::size_t pixel = static_cast<std::size_t>(y * buffers_.width + x);
    const int taken = buffers_.taken[pixel];
    if (buffers_.traits[pixel] & kDetail) return more(taken, edge_);
    const std::uint32_t kind = buffers_.kinds[pixel];
    bool edge = (buffers_.traits[pixel] & kMixed) != 0;
    std::uint32_t all_kinds = kind;
    for (int j = std::max(y - 1, 0); j <= std::min(y + 1, buffers_.height - 1); ++j)
      for (int i = std::max(x - 1, 0); i <= std::min(x + 1, buffers_.width - 1); ++i) {
        const std::uint32_t other =
            buffers_.kinds[static_cast<std::size_t>(j * buffers_.width + i)];
        edge = edge || other != kind;
        all_kinds |= other;
      }
    if (edge) {
      // Outlines of people make the matte. The edge of a shadow is soft by itself.
      const bool figure = all_kinds >= kKindFigure || (buffers_.traits[pixel] & kFigure);
      return more(taken, figure ? edge_ : all_kinds < kKindSky ? 4u : std::max(edge_ / 2, 4u));
    }
    if (buffers_.traits[pixel] & kFigure) return taken < 4 ? 4 : 0;
    if (buffers_.traits[pixel] & kStand)
      return taken < options_.crowd_samples ? std::min(options_.crowd_samples, 4) : 0;
    return 0;
  }
  static int more(int taken, unsigned samples) {
    return taken < static_cast<int>(samples) ? static_cast<int>(samples) : 0;
  }

  void second_tile(int tile) {
    const Rectangle r = rectangle(tile);
    Queue queue(*this, motion_of(r));
    for (int y = r.y0; y < r.y1; ++y)
      for (int x = r.x0; x < r.x1; ++x) {
        const int count = wanted_[static_cast<std::size_t>(y * buffers_.width + x)];
        if (count > 0) queue.add(x, y, count);
      }
  }

  const Exposure& exposure_;
  const RenderOptions& options_;
  bool moving_;
  Shader shader_;
  unsigned edge_ = 16;
  std::unique_ptr<LensTable> still_;
  std::vector<LensTable> lenses_;
  std::vector<std::pair<int, Pattern>> patterns_;
  int columns_ = 0, rows_ = 0;
  int across_ = 0;                       // blocks
  std::vector<std::uint32_t> net_bits_;  // of each block
  std::vector<std::uint8_t> solids_;     // of each block
  Outlines outlines_;
  std::vector<std::uint8_t> wanted_;  // samples of each pixel
  Buffers buffers_{};
};

}  // namespace

struct Renderer::Impl {
  Impl(const world::World& w, const people::Cast* c)
      : world(w),
        cast(c),
        // World keeps its data alive for as long as this copy of it lives.
        ground(std::shared_ptr<const world::WorldData>(std::shared_ptr<void>(), &world.data())),
        nets(world.data()) {}

  std::shared_ptr<const Moment> moment_at(double open_s, double close_s) const {
    const std::lock_guard lock(mutex);
    for (const Kept& kept : moments)
      if (kept.open_s == open_s && kept.close_s == close_s) return kept.moment;
    auto moment = std::make_shared<const Moment>(ground, cast, open_s, close_s);
    if (moments.size() >= kMoments) moments.erase(moments.begin());
    moments.push_back({open_s, close_s, moment});
    return moment;
  }

  world::World world;
  const people::Cast* cast;
  Ground ground;
  Nets nets;
  struct Kept {
    double open_s, close_s;
    std::shared_ptr<const Moment> moment;
  };
  mutable std::mutex mutex;
  mutable std::vector<Kept> moments;
};

Renderer::Renderer(const world::World& world, const people::Cast* cast)
    : impl_(std::make_unique<Impl>(world, cast)) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

Picture Renderer::render(const Exposure& exposure, const RenderOptions& options) const {
  const auto moment = impl_->moment_at(exposure.open_s, exposure.close_s);
  Frame frame(impl_->ground, *moment, impl_->nets, exposure, options);
  frame.first_pass();
  frame.second_pass();
  Picture picture = frame.picture();
  const world::WorldData& data = impl_->world.data();
  if (data.spec.weather.rain > 0) {
    const world::Lighting& lighting = frame.shader().lighting();
    float light = lighting.ambient(Eigen::Vector3f::UnitY()).mean();
    for (const world::Lamp& lamp : lighting.lamps) light += 0.3f * lamp.colour.mean();
    const auto microseconds = static_cast<std::int64_t>(std::llround(exposure.open_s * 1e6));
    const Eigen::Vector3d place = geometry::origin(exposure.open.cam_from_world);
    const auto key =
        world::hashed(data.stream, static_cast<std::uint32_t>(microseconds),
                      static_cast<std::uint32_t>(microseconds >> 32),
                      static_cast<std::uint32_t>(std::llround(100 * place.x() + 1e5 * place.y())));
    add_rain(picture.radiance, data.spec.weather.rain, light, exposure.open.model.fx, key);
  }
  return picture;
}

geometry::Mesh mesh_of(const people::Cast& cast, double time_s) {
  geometry::Mesh mesh;
  const auto add = [&](const people::Body& body, const people::Posture& posture) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), posture.positions.begin(), posture.positions.end());
    for (const auto& t : body.triangles)
      mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  };
  for (std::size_t i = 0; i < cast.people(); ++i) add(cast.body(i), cast.posture(i, time_s));
  if (cast.has_ball() && cast.ball(time_s).present)
    add(cast.ball_body(), cast.ball_posture(time_s));
  return mesh;
}

}  // namespace touchline::sim::render
