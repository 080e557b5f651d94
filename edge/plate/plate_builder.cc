#include "edge/plate/plate_builder.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "edge/plate/frame_sampler.h"
#include "edge/plate/sample_stack.h"
#include "edge/plate/still_seed.h"
#include "edge/plate/turf_colour.h"
#include "edge/plate/turf_fill.h"
#include "edge/plate/zones.h"

namespace touchline::plate {
namespace {

constexpr int kSize = image::kPlateTileSize;
constexpr int kApron = 12;
constexpr int kWide = kSize + 2 * kApron;
constexpr int kRejectReach = 3;  // pixels round a person that are not learnt either
constexpr int kDoubtReach = 12;  // pixels round a person where doubtful colours are not learnt
constexpr int kFrameBorder = 0;  // pixels at the frame's edge that are not learnt
constexpr int kFillApron = 64;   // pixels of the neighbouring tiles that turf is interpolated from

std::size_t wide_index(int x, int y) {
  return static_cast<std::size_t>(y + kApron) * kWide + static_cast<std::size_t>(x + kApron);
}
std::size_t tile_index(int x, int y) {
  return static_cast<std::size_t>(y) * kSize + static_cast<std::size_t>(x);
}

PlateOptions bounded(PlateOptions o) {
  o.learn_frames = std::clamp(o.learn_frames, 4, 500);
  o.samples = std::clamp(o.samples, 3, 32);
  o.publish_frames = std::clamp(o.publish_frames, 1, 10000);
  o.update_every = std::clamp(o.update_every, 1, 1000);
  o.update_rate = std::clamp(o.update_rate, 0.001, 0.5);
  o.noise_codes = std::clamp(o.noise_codes, 0.25, 50.0);
  o.filled_codes = std::clamp(o.filled_codes, 1.0, 200.0);
  o.turf_margin_m = std::clamp(o.turf_margin_m, 0.0, 20.0);
  o.line_tolerance_m = std::clamp(o.line_tolerance_m, 0.0, 0.5);
  o.line_tolerance_px = std::clamp(o.line_tolerance_px, 0.0, 10.0);
  o.occluder_margin_px = std::clamp(o.occluder_margin_px, 0.0, 20.0);
  o.max_tiles = std::clamp(o.max_tiles, 8, 4096);
  return o;
}

template <typename T>
base::Status in_bounds(const char* field, T value, T low, T high) {
  if (value >= low && value <= high) return {};
  return base::fail(base::ErrorKind::kConfiguration, field,
                    fmt::format("{} is outside {}..{}", value, low, high), "correct the value");
}

// 1 within `reach` pixels (a square) of a 1.
void widen(const std::vector<std::uint8_t>& in, int reach, std::vector<std::uint8_t>& across,
           std::vector<std::uint8_t>& out) {
  across = in;
  for (int y = 0; y < kWide; ++y) {
    const std::uint8_t* from = &in[static_cast<std::size_t>(y) * kWide];
    std::uint8_t* to = &across[static_cast<std::size_t>(y) * kWide];
    for (int k = 1; k <= reach; ++k) {
      for (int x = 0; x + k < kWide; ++x) to[x] |= from[x + k];
      for (int x = k; x < kWide; ++x) to[x] |= from[x - k];
    }
  }
  out = across;
  for (int y = 0; y < kWide; ++y) {
    std::uint8_t* to = &out[static_cast<std::size_t>(y) * kWide];
    for (int v = std::max(0, y - reach); v <= std::min(kWide - 1, y + reach); ++v) {
      const std::uint8_t* from = &across[static_cast<std::size_t>(v) * kWide];
      for (int x = 0; x < kWide; ++x) to[x] |= from[x];
    }
  }
}

struct TileState {
  std::vector<std::uint8_t> zones;  // with apron
  std::vector<std::uint8_t> seen = std::vector<std::uint8_t>(kSize * kSize, 0);
  std::vector<std::uint32_t> seed;  // packed samples of the stills; empty = not looked up
  std::optional<SampleStack> learning;
  image::PlateTile tile;
  std::uint64_t last_seen = 0;
  bool changed = false;  // since the median was taken
};

}  // namespace

base::Status PlateOptions::validate() const {
  for (const auto& s :
       {in_bounds("learn_frames", learn_frames, 4, 500), in_bounds("samples", samples, 3, 32),
        in_bounds("publish_frames", publish_frames, 1, 10000),
        in_bounds("update_every", update_every, 1, 1000),
        in_bounds("update_rate", update_rate, 0.001, 0.5),
        in_bounds("noise_codes", noise_codes, 0.25, 50.0),
        in_bounds("filled_codes", filled_codes, 1.0, 200.0),
        in_bounds("turf_margin_m", turf_margin_m, 0.0, 20.0),
        in_bounds("line_tolerance_m", line_tolerance_m, 0.0, 0.5),
        in_bounds("line_tolerance_px", line_tolerance_px, 0.0, 10.0),
        in_bounds("occluder_margin_px", occluder_margin_px, 0.0, 20.0),
        in_bounds("max_tiles", max_tiles, 8, 4096)})
    if (!s) return s;
  return {};
}

struct PlateBuilder::State {
  pitch::PitchModel pitch;
  PlateOptions options;
  image::PlateSnapshot sphere;  // without tiles: version, centre, scale, colour
  TurfColour turf;
  StillSeed stills;
  std::map<image::PlateTileKey, TileState> tiles;
  std::shared_ptr<const image::PlateSnapshot> current;
  int frames = 0;
  int frames_at_publish = -1;
  bool seeds_changed = false;
  TileSamples samples;
  std::vector<std::uint8_t> accepted;  // of `samples`: 1 = may be learnt, with apron
  std::vector<std::uint8_t> foreign, body, near_body, around_body, scratch;

  TileState& tile(const image::PlateTileKey& key);
  void drop_oldest();
  void observe_turf(const image::Frame& frame, const geometry::CameraEstimate& camera);
  void classify(const TileState& t);
  void learn(TileState& t, std::vector<std::uint32_t>& layer);
  void follow(TileState& t);
  void take_medians();
  void apply_seeds(image::PlateSnapshot& out);
  void fill(const image::PlateTileKey& key, const TileState& t, image::PlateTile& out) const;
};

TileState& PlateBuilder::State::tile(const image::PlateTileKey& key) {
  const auto found = tiles.find(key);
  if (found != tiles.end()) return found->second;
  TileState& t = tiles[key];
  t.zones = tile_zones(sphere, key, kApron, pitch,
                       {options.turf_margin_m, 6.0, options.line_tolerance_m,
                        options.line_tolerance_px, options.occluder_margin_px});
  t.learning.emplace(options.samples);
  return t;
}

void PlateBuilder::State::drop_oldest() {
  while (static_cast<int>(tiles.size()) > options.max_tiles) {
    auto oldest = tiles.begin();
    for (auto it = tiles.begin(); it != tiles.end(); ++it)
      if (it->second.last_seen < oldest->second.last_seen) oldest = it;
    tiles.erase(oldest);
  }
}

// Colours of a lattice of pixels whose rays end well inside the pitch.
void PlateBuilder::State::observe_turf(const image::Frame& frame,
                                       const geometry::CameraEstimate& camera) {
  constexpr int kLattice = 12;
  const auto shift = image::chroma_shift(frame.format);
  for (int y = kLattice / 2; y < frame.height(); y += kLattice)
    for (int x = kLattice / 2; x < frame.width(); x += kLattice) {
      const auto hit = pitch::intersect_turf(
          pitch, sphere.centre_in_world,
          geometry::ray_in_world(camera, {static_cast<double>(x), static_cast<double>(y)}));
      if (!hit || std::abs(hit->x()) > pitch.length_m / 2 || std::abs(hit->y()) > pitch.width_m / 2)
        continue;
      turf.observe(static_cast<float>(frame.planes[0](x, y)),
                   static_cast<float>(frame.planes[1](x >> shift.x, y >> shift.y)),
                   static_cast<float>(frame.planes[2](x >> shift.x, y >> shift.y)));
    }
  turf.update();
}

// Marks which samples may be learnt: off the turf all, on it turf and paint that are not close to
// anything else, and what may be bare ground where nobody is near.
void PlateBuilder::State::classify(const TileState& t) {
  const std::size_t area = t.zones.size();
  accepted.assign(area, 0);
  foreign.assign(area, 0);
  for (std::size_t i = 0; i < area; ++i) {
    if (!samples.inside[i]) continue;
    const std::uint8_t zone = t.zones[i];
    if (zone == 0) {
      accepted[i] = 1;
      continue;
    }
    if (!turf.ready()) {
      foreign[i] = 1;
      continue;
    }
    const float y = 0.5f * static_cast<float>(samples.y[i]);
    const float cb = samples.cb[i];
    const float cr = samples.cr[i];
    const bool paint_may_be = zone & (kPaintBand | kPerhapsTurf);
    if (paint_may_be ? turf.is_painted(y, cb, cr) : turf.is_turf(y, cb, cr))
      accepted[i] = 1;
    else if (turf.is_doubtful(y, cb, cr))
      accepted[i] = 2;
    else
      foreign[i] = 1;
  }
  // Single pixels are noise; three in a neighbourhood are a person, whose rim is mixed with turf.
  body.assign(area, 0);
  bool anybody = false;
  for (int y = 1; y + 1 < kWide; ++y)
    for (int x = 1; x + 1 < kWide; ++x) {
      const auto i = static_cast<std::size_t>(y) * kWide + static_cast<std::size_t>(x);
      const auto* a = &foreign[i - kWide - 1];
      const auto* b = &foreign[i - 1];
      const auto* c = &foreign[i + kWide - 1];
      const int sum = a[0] + a[1] + a[2] + b[0] + b[1] + b[2] + c[0] + c[1] + c[2];
      body[i] = sum >= 3 && b[1];
      anybody = anybody || body[i];
    }
  if (!anybody) {
    for (auto& a : accepted) a = a != 0;
    return;
  }
  widen(body, kRejectReach, scratch, near_body);
  widen(body, kDoubtReach, scratch, around_body);
  for (std::size_t i = 0; i < area; ++i) {
    if (t.zones[i] && (near_body[i] || (accepted[i] == 2 && around_body[i]))) accepted[i] = 0;
    if (accepted[i]) accepted[i] = 1;
  }
}

void PlateBuilder::State::learn(TileState& t, std::vector<std::uint32_t>& layer) {
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const std::size_t w = wide_index(x, y);
      if (!samples.inside[w]) continue;
      const std::size_t i = tile_index(x, y);
      t.seen[i] = 1;
      const bool ok = accepted[w];
      if (!ok && !(t.zones[w] & kPerhapsTurf)) continue;
      layer[i] = pack_sample(samples.y[w], samples.cb[w], samples.cr[w], ok);
    }
  t.changed = true;
}

// The running mean and deviation. A step is bounded by two deviations, so that the mean follows the
// median: light that changes is followed, who walks by is not.
void PlateBuilder::State::follow(TileState& t) {
  const double noise = options.noise_codes * 16;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const std::size_t w = wide_index(x, y);
      if (!samples.inside[w]) continue;
      t.seen[tile_index(x, y)] = 1;
      if (!accepted[w]) continue;
      const std::array<int, 3> value{samples.y[w] * 8, samples.cb[w] * 16, samples.cr[w] * 16};
      auto& count = t.tile.count(x, y);
      if (count == 0) {
        for (std::size_t c = 0; c < 3; ++c) {
          t.tile.mean[c](x, y) = static_cast<std::uint16_t>(value[c]);
          t.tile.deviation[c](x, y) = static_cast<std::uint16_t>(options.filled_codes * 16);
        }
        count = 1;
        continue;
      }
      const double rate = std::max(options.update_rate, 1.0 / (count + 1.0));
      for (std::size_t c = 0; c < 3; ++c) {
        auto& mean = t.tile.mean[c](x, y);
        auto& deviation = t.tile.deviation[c](x, y);
        const double limit = 2.0 * deviation;
        const double step = std::clamp(static_cast<double>(value[c] - mean), -limit, limit);
        mean = static_cast<std::uint16_t>(std::lround(mean + rate * step));
        const double spread = deviation + rate * (1.25 * std::abs(step) - deviation);
        deviation = static_cast<std::uint16_t>(std::lround(std::max(spread, noise)));
      }
      if (count < 255) ++count;
    }
  t.changed = true;
}

void PlateBuilder::State::take_medians() {
  std::vector<std::uint8_t> prefer(static_cast<std::size_t>(kSize) * kSize);
  for (auto& [key, t] : tiles) {
    if (!t.learning || !t.changed) continue;
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x)
        prefer[tile_index(x, y)] = t.zones[wide_index(x, y)] & kPerhapsTurf;
    t.learning->median(prefer, options.noise_codes, t.tile);
    t.changed = false;
    if (t.learning->frames() >= options.learn_frames) t.learning.reset();
  }
}

void PlateBuilder::State::apply_seeds(image::PlateSnapshot& out) {
  if (stills.empty()) return;
  StillFit fit;
  for (auto& [key, t] : tiles) {
    if (t.seed.empty() || seeds_changed) {
      t.seed = stills.look_up(sphere, key);
      for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x)
          if (!(t.zones[wide_index(x, y)] & (kTurf | kOccluder))) t.seed[tile_index(x, y)] = 0;
    }
    for (int y = 4; y < kSize; y += 8)
      for (int x = 4; x < kSize; x += 8)
        if (t.seed[tile_index(x, y)] && !t.tile.count.empty() && t.tile.count(x, y) >= 3)
          fit.add(t.seed[tile_index(x, y)],
                  {t.tile.mean[0](x, y) / 16.f, t.tile.mean[1](x, y) / 16.f,
                   t.tile.mean[2](x, y) / 16.f});
  }
  seeds_changed = false;
  if (!fit.solve()) return;
  const auto deviation =
      static_cast<std::uint16_t>(16 * std::max(2.0 * fit.rms(), 2 * options.noise_codes));
  for (auto& [key, t] : tiles) {
    image::PlateTile& tile = out.tiles[key];
    if (tile.count.empty()) continue;
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        const std::uint32_t seed = t.seed[tile_index(x, y)];
        // A goal that is seldom seen as turf and net has somebody in front of it.
        const std::uint8_t zone = t.zones[wide_index(x, y)];
        const bool goal = zone & kOccluder;
        if (!seed || tile.count(x, y) > (goal ? 1 : 0)) continue;
        const auto colour = fit.apply(seed);
        const bool paint = zone & kPaintBand;
        if (!goal && !(paint ? turf.is_painted(colour[0], colour[1], colour[2])
                             : turf.is_turf(colour[0], colour[1], colour[2])))
          continue;
        for (std::size_t c = 0; c < 3; ++c) {
          tile.mean[c](x, y) = static_cast<std::uint16_t>(std::clamp(colour[c], 0.f, 1023.f) * 16);
          tile.deviation[c](x, y) = deviation;
        }
        tile.count(x, y) = 1;
      }
  }
}

void PlateBuilder::State::fill(const image::PlateTileKey& key, const TileState& t,
                               image::PlateTile& out) const {
  if (out.count.empty()) return;
  bool needed = false;
  for (int y = 0; y < kSize && !needed; ++y)
    for (int x = 0; x < kSize && !needed; ++x)
      needed =
          out.count(x, y) == 0 && t.seen[tile_index(x, y)] && (t.zones[wide_index(x, y)] & kTurf);
  if (!needed) return;

  constexpr int kSide = kSize + 2 * kFillApron;
  SparseColours grass(kSide);
  SparseColours paint(kSide);
  for (int row = -1; row <= 1; ++row)
    for (int column = -1; column <= 1; ++column) {
      const auto found = tiles.find({key.column + column, key.row + row});
      if (found == tiles.end() || found->second.tile.count.empty()) continue;
      const TileState& from = found->second;
      for (int y = 0; y < kSize; ++y) {
        const int v = y + row * kSize + kFillApron;
        if (v < 0 || v >= kSide) continue;
        for (int x = 0; x < kSize; ++x) {
          const int u = x + column * kSize + kFillApron;
          if (u < 0 || u >= kSide || from.tile.count(x, y) == 0) continue;
          const std::uint8_t zone = from.zones[wide_index(x, y)];
          SparseColours* into = zone == kTurf ? &grass : (zone & kPaintCore) ? &paint : nullptr;
          if (!into) continue;
          const auto at = static_cast<std::size_t>(v) * kSide + static_cast<std::size_t>(u);
          into->y[at] = from.tile.mean[0](x, y);
          into->cb[at] = from.tile.mean[1](x, y);
          into->cr[at] = from.tile.mean[2](x, y);
          into->weight[at] = 1;
        }
      }
    }
  if (!fill_unknown(grass)) return;
  const bool painted = fill_unknown(paint);
  const auto deviation = static_cast<std::uint16_t>(16 * options.filled_codes);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const std::uint8_t zone = t.zones[wide_index(x, y)];
      if (out.count(x, y) || !t.seen[tile_index(x, y)] || !(zone & kTurf)) continue;
      const auto at = static_cast<std::size_t>(y + kFillApron) * kSide +
                      static_cast<std::size_t>(x + kFillApron);
      const SparseColours& from = painted && (zone & kPaintCore) ? paint : grass;
      out.mean[0](x, y) = static_cast<std::uint16_t>(from.y[at]);
      out.mean[1](x, y) = static_cast<std::uint16_t>(from.cb[at]);
      out.mean[2](x, y) = static_cast<std::uint16_t>(from.cr[at]);
      for (auto& plane : out.deviation) plane(x, y) = deviation;
      out.count(x, y) = 1;
    }
}

PlateBuilder::PlateBuilder(const pitch::PitchModel& pitch, const Eigen::Vector3d& centre_in_world,
                           double radians_per_px, const PlateOptions& options)
    : state_(std::make_unique<State>()) {
  state_->pitch = pitch;
  state_->options = bounded(options);
  state_->sphere.centre_in_world = centre_in_world;
  state_->sphere.radians_per_px = radians_per_px;
}
PlateBuilder::~PlateBuilder() = default;
PlateBuilder::PlateBuilder(PlateBuilder&&) noexcept = default;
PlateBuilder& PlateBuilder::operator=(PlateBuilder&&) noexcept = default;

int PlateBuilder::frames() const { return state_->frames; }

void PlateBuilder::seed(const image::Frame& still, const geometry::CameraEstimate& estimate) {
  if (estimate.lost() || still.width() != estimate.model.width ||
      still.height() != estimate.model.height)
    return;
  state_->stills.add(still, estimate);
  state_->seeds_changed = true;
}

void PlateBuilder::add(const image::Frame& frame, const geometry::CameraEstimate& estimate) {
  State& s = *state_;
  if (estimate.lost() || frame.width() != estimate.model.width ||
      frame.height() != estimate.model.height || frame.width() < 16 || frame.height() < 16)
    return;
  const auto keys = touched_tiles(s.sphere, estimate, s.options.max_tiles);
  if (keys.empty()) return;
  const int number = s.frames++;
  if (number == 0) s.sphere.colour = frame.colour;
  if (number < 4 || number == 8 || number == 16 || number % 50 == 32)
    s.observe_turf(frame, estimate);

  for (const auto& key : keys) {
    TileState& t = s.tile(key);
    t.last_seen = static_cast<std::uint64_t>(s.frames);
    const bool wanted = t.learning ? t.learning->wanted() : number % s.options.update_every == 0;
    if (wanted) {
      sample_tile(s.sphere, key, kApron, frame, estimate, kFrameBorder, s.samples);
      if (s.samples.seen == 0) continue;
      s.classify(t);
      if (!t.learning)
        s.follow(t);
      else if (auto* layer = t.learning->next_layer())
        s.learn(t, *layer);
    } else if (t.learning) {
      t.learning->skip();
    }
  }
  s.drop_oldest();
}

std::shared_ptr<const image::PlateSnapshot> PlateBuilder::snapshot(bool fresh) {
  State& s = *state_;
  const bool due = !s.current || s.frames - s.frames_at_publish >= s.options.publish_frames ||
                   (fresh && (s.frames != s.frames_at_publish || s.seeds_changed));
  if (!due) return s.current;
  s.take_medians();
  auto next = std::make_shared<image::PlateSnapshot>(s.sphere);
  next->version = (s.current ? s.current->version : 0) + 1;
  for (const auto& [key, t] : s.tiles)
    if (!t.tile.count.empty()) next->tiles[key] = t.tile;
  s.apply_seeds(*next);
  for (const auto& [key, t] : s.tiles) {
    const auto found = next->tiles.find(key);
    if (found != next->tiles.end()) s.fill(key, t, found->second);
  }
  std::erase_if(next->tiles, [](const auto& entry) { return entry.second.count.empty(); });
  s.frames_at_publish = s.frames;
  s.current = std::move(next);
  return s.current;
}

}  // namespace touchline::plate
