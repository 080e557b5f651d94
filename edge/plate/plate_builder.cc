#include "edge/plate/plate_builder.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "edge/plate/acceptance.h"
#include "edge/plate/frame_sampler.h"
#include "edge/plate/resumed_tile.h"
#include "edge/plate/running_mean.h"
#include "edge/plate/seed_blend.h"
#include "edge/plate/still_seed.h"
#include "edge/plate/tile_state_internal.h"
#include "edge/plate/turf_colour.h"
#include "edge/plate/zones.h"

namespace touchline::plate {
namespace {

constexpr int kFrameBorder = 0;     // pixels at the frame's edge that are not learnt
constexpr double kBoardCodes = 12;  // least deviation of boards behind a goal, in stills
constexpr int kEnoughTold = 20000;  // pixels that say whether a resumed plate is of this place
constexpr int kRefitVersions = 20;  // versions after which stills are fitted to the video anew

}  // namespace

struct PlateBuilder::State {
  pitch::PitchModel pitch;
  PlateOptions options;
  image::PlateSnapshot sphere;  // without tiles: version, centre, scale, colour
  TurfColour turf;
  StillSeed stills;
  TileStates tiles;
  std::shared_ptr<const image::PlateSnapshot> current;
  int frames = 0;
  int frames_at_publish = -1;
  bool seeds_changed = false;
  TileSamples samples;
  Acceptance acceptance;
  StillFit fit;
  BlendOptions blend;
  Comparison resumed;
  std::optional<double> resumed_apart;
  bool fitted = false;
  std::uint32_t fitted_at = 0;  // version

  TileState& tile(const image::PlateTileKey& key);
  void drop_oldest();
  void observe_turf(const image::Frame& frame, const geometry::CameraEstimate& camera);
  bool due(const image::PlateTileKey& key, const TileState& t, std::uint64_t nodes,
           int number) const;
  int spacing_of(const TileState& t) const;
  void learn(TileState& t, const std::vector<std::uint8_t>& accepted, int number);
  void note_seen(TileState& t) const;
  bool take_medians();
  void judge_resumed();
  void find_stale();
  void look_up_seeds();
  void fit_seeds(bool learnt);
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

// Frames between two samples of a tile that is learnt: fewer at first, so that a median soon has
// enough to go by.
int PlateBuilder::State::spacing_of(const TileState& t) const {
  const int spacing = (options.learn_frames + options.samples - 1) / options.samples;
  return t.frames <= options.samples ? std::min(spacing, 2) : spacing;
}

// A tile is sampled when it comes into view, when more of it does, and then every few frames; each
// tile has its turn, so that no frame costs much more than another.
bool PlateBuilder::State::due(const image::PlateTileKey& key, const TileState& t,
                              std::uint64_t nodes, int number) const {
  if (t.sampled_at < 0 || (nodes & ~t.nodes) != 0) return true;
  if (t.learning && t.frames > options.learn_frames) return false;
  const int spacing = t.learning ? spacing_of(t) : options.update_every * (1 + t.calm);
  const int turn = (key.column + 2 * key.row) % spacing;
  return (number + turn + spacing) % spacing == 0 && 2 * (number - t.sampled_at) >= spacing;
}

void PlateBuilder::State::note_seen(TileState& t) const {
  for (int y = 0; y < kSize; ++y) {
    const std::uint8_t* inside = &samples.inside[wide_index(0, y)];
    const std::uint8_t* doubt = &acceptance.doubted()[wide_index(0, y)];
    std::uint8_t* seen = &t.seen[tile_index(0, y)];
    std::uint8_t* doubted = &t.doubted[tile_index(0, y)];
    for (int x = 0; x < kSize; ++x) {
      const bool full = seen[x] == 255;
      seen[x] = static_cast<std::uint8_t>(seen[x] + (full ? 0 : inside[x]));
      doubted[x] = static_cast<std::uint8_t>(doubted[x] + (full ? 0 : doubt[x]));
    }
  }
}

void PlateBuilder::State::learn(TileState& t, const std::vector<std::uint8_t>& accepted,
                                int number) {
  std::vector<std::uint32_t>& layer = t.learning->next_layer(number, spacing_of(t));
  for (int y = 0; y < kSize; ++y) {
    const std::size_t w = wide_index(0, y);
    const std::uint8_t* inside = &samples.inside[w];
    const std::uint8_t* ok = &accepted[w];
    const std::uint8_t* zones = &t.zones[w];
    const std::uint16_t* luma = &samples.y[w];
    const std::uint16_t* cb = &samples.cb[w];
    const std::uint16_t* cr = &samples.cr[w];
    std::uint32_t* to = &layer[tile_index(0, y)];
    for (int x = 0; x < kSize; ++x) {
      const bool keep = inside[x] && (ok[x] || (zones[x] & kPerhapsTurf));
      const std::uint32_t sample = pack_sample(luma[x], cb[x], cr[x], ok[x] != 0);
      to[x] = keep ? sample : 0U;
    }
  }
}

// True when any tile had one.
bool PlateBuilder::State::take_medians() {
  bool any = false;
  image::PlateTile live;
  std::vector<std::uint8_t> prefer(static_cast<std::size_t>(kSize) * kSize);
  for (auto& [key, t] : tiles) {
    if (!t.learning) continue;
    if (t.changed) {
      for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x)
          prefer[tile_index(x, y)] = t.zones[wide_index(x, y)] & kPerhapsTurf;
      any = true;
      t.learning->median(prefer, options.noise_codes, t.resumed ? live : t.tile);
      if (t.resumed) {  // find_stale() says whether that is news
        const Comparison told = take_live(live, options.noise_codes, t.tile);
        resumed.pixels += told.pixels;
        resumed.apart += told.apart;
        continue;
      }
      t.changed = false;
      t.stale = true;
      // Turf of the neighbours is interpolated from this.
      for (int row = -1; row <= 1; ++row)
        for (int column = -1; column <= 1; ++column) {
          const auto near = tiles.find({key.column + column, key.row + row});
          if (near != tiles.end()) near->second.stale = true;
        }
    }
  }
  judge_resumed();
  for (auto& [key, t] : tiles)
    if (t.learning && t.frames >= options.learn_frames) {
      t.learning.reset();
      t.resumed = false;
    }
  return any;
}

// Once: what was resumed and shows something else than the camera is dropped where live frames have
// not said better.
void PlateBuilder::State::judge_resumed() {
  if (resumed_apart || resumed.pixels < kEnoughTold) return;
  resumed_apart = static_cast<double>(resumed.apart) / resumed.pixels;
  if (*resumed_apart <= 0.5) return;
  std::erase_if(
      tiles, [](const auto& entry) { return entry.second.resumed && entry.second.sampled_at < 0; });
  std::vector<std::uint8_t> prefer(static_cast<std::size_t>(kSize) * kSize, 0);
  for (auto& [key, t] : tiles) {
    if (!t.resumed) continue;
    image::PlateTile live;
    t.learning->median(prefer, options.noise_codes, live);
    keep_live_only(live, t.tile);
    t.resumed = false;
    t.changed = t.stale = true;
  }
}

// Tiles whose running mean left what is published. Those that stay with it for long are looked at
// less often, until they or many others change.
void PlateBuilder::State::find_stale() {
  int looked_at = 0;
  int moved = 0;
  for (auto& [key, t] : tiles) {
    if (!t.changed) continue;
    const auto published =
        current ? current->tiles.find(key) : decltype(current->tiles.find(key)){};
    const bool first = !current || published == current->tiles.end();
    const bool news = first || differs(*published->second, t.tile);
    t.stale = t.stale || news;
    t.changed = false;
    if (t.learning) continue;
    ++looked_at;
    moved += news ? 1 : 0;
    t.calm = news ? 0 : std::min(t.calm + 1, kMostCalm);
  }
  if (moved >= 3 && moved * 3 >= looked_at)
    for (auto& [key, t] : tiles) t.calm = 0;
}

void PlateBuilder::State::look_up_seeds() {
  if (stills.empty()) return;
  for (auto& [key, t] : tiles) {
    if (t.tile.count.empty() || (!t.seed.empty() && !seeds_changed)) continue;
    std::uint8_t zoned = 0;
    for (const std::uint8_t zone : t.zones) zoned |= zone & (kTurf | kOccluder);
    if (!zoned) {
      t.seed.assign(static_cast<std::size_t>(kSize) * kSize, 0U);
      continue;
    }
    t.seed = stills.look_up(sphere, key);
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x)
        if (!(t.zones[wide_index(x, y)] & (kTurf | kOccluder))) t.seed[tile_index(x, y)] = 0;
  }
}

void PlateBuilder::State::fit_seeds(bool learnt) {
  const std::uint32_t version = current ? current->version : 0;
  if (stills.empty() || !(learnt || seeds_changed || version >= fitted_at + kRefitVersions)) return;
  fit = {};
  StillFit of_all;
  for (const auto& [key, t] : tiles) {
    if (t.seed.empty() || t.tile.count.empty()) continue;
    for (int y = 4; y < kSize; y += 8)
      for (int x = 4; x < kSize; x += 8)
        if (t.seed[tile_index(x, y)] && t.tile.count(x, y) >= 3) {
          const std::array<float, 3> video{t.tile.mean[0](x, y) / 16.f, t.tile.mean[1](x, y) / 16.f,
                                           t.tile.mean[2](x, y) / 16.f};
          of_all.add(t.seed[tile_index(x, y)], video);
          // Nets and paint tell how sharp the still is, not what light it was taken in.
          if (t.zones[wide_index(x, y)] == kTurf) fit.add(t.seed[tile_index(x, y)], video);
        }
  }
  fitted = fit.solve() && of_all.solve();
  const auto& apart = of_all.rms();
  blend.noise_codes = options.noise_codes;
  blend.board_codes = std::max(
      kBoardCodes, 2 * Eigen::Vector3d(apart[0], apart[1], apart[2]).norm() / std::sqrt(3.0));
  fitted_at = version;
}

PlateBuilder::PlateBuilder(const pitch::PitchModel& pitch, const Eigen::Vector3d& centre_in_world,
                           double radians_per_px, const PlateOptions& options)
    : state_(std::make_unique<State>()) {
  state_->pitch = pitch;
  state_->options = options.bounded();
  state_->sphere.centre_in_world = centre_in_world;
  state_->sphere.radians_per_px = radians_per_px;
}
PlateBuilder::~PlateBuilder() = default;
PlateBuilder::PlateBuilder(PlateBuilder&&) noexcept = default;
PlateBuilder& PlateBuilder::operator=(PlateBuilder&&) noexcept = default;

int PlateBuilder::frames() const { return state_->frames; }

std::optional<double> PlateBuilder::resumed_apart() const { return state_->resumed_apart; }

base::Status PlateBuilder::resume(const image::PlateSnapshot& saved, double most_moved_m) {
  State& s = *state_;
  const auto refused = [](std::string what) {
    return base::fail(base::ErrorKind::kArgument, "saved plate", std::move(what));
  };
  if (s.frames > 0 || !s.tiles.empty()) return refused("the plate was begun already");
  if (saved.radians_per_px != s.sphere.radians_per_px)
    return refused(
        fmt::format("{} radians a pixel, not {}", saved.radians_per_px, s.sphere.radians_per_px));
  const double moved = (saved.centre_in_world - s.sphere.centre_in_world).norm();
  if (!(moved <= most_moved_m))
    return refused(
        fmt::format("of a camera {:.2f} m from here, more than {:.2f} m", moved, most_moved_m));
  auto first = std::make_shared<image::PlateSnapshot>(s.sphere);
  s.sphere.colour = first->colour = saved.colour;
  first->version = std::max(s.options.first_version, saved.version + 1);
  for (const auto& [key, tile] : saved.tiles) {
    if (tile->count.width() != kSize || tile->count.height() != kSize) continue;
    if (static_cast<int>(first->tiles.size()) >= s.options.max_tiles) break;
    first->tiles.emplace(key, tile);
    TileState& t = s.tile(key);
    t.tile = with_less_trust(*tile, s.options.resumed_frames);
    t.resumed = true;
    for (std::size_t i = 0; i < t.seen.size(); ++i) t.seen[i] = t.tile.count.data()[i] > 0;
  }
  s.current = std::move(first);
  return {};
}

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
    const bool all_seen = t.nodes == ~std::uint64_t{0};
    const std::uint64_t nodes = all_seen ? 0 : nodes_in_view(s.sphere, key, estimate, 0);
    if (t.learning && t.sampled_at >= 0) ++t.frames;
    if (!s.due(key, t, nodes, number)) continue;
    sample_tile(s.sphere, key, kApron, frame, estimate, kFrameBorder, s.samples);
    if (s.samples.seen == 0) continue;
    t.frames = std::max(t.frames, 1);
    t.sampled_at = number;
    t.nodes |= nodes;
    const auto& accepted = s.acceptance.classify(t.zones, s.samples, s.turf);
    s.note_seen(t);
    if (t.learning)
      s.learn(t, accepted, number);
    else
      follow(s.samples, accepted,
             {s.options.update_rate, s.options.noise_codes, s.options.filled_codes}, t.tile);
    t.changed = true;
  }
  s.drop_oldest();
}

std::shared_ptr<const image::PlateSnapshot> PlateBuilder::snapshot(bool fresh) {
  State& s = *state_;
  const bool due = !s.current || s.frames - s.frames_at_publish >= s.options.publish_frames ||
                   (fresh && (s.frames != s.frames_at_publish || s.seeds_changed));
  if (!due) return s.current;
  const bool learnt = s.take_medians();
  s.find_stale();
  s.look_up_seeds();
  s.fit_seeds(learnt);
  if (s.seeds_changed)
    for (auto& [key, t] : s.tiles) t.stale = true;
  s.seeds_changed = false;
  s.frames_at_publish = s.frames;
  const bool dropped =
      s.current && std::any_of(s.current->tiles.begin(), s.current->tiles.end(),
                               [&](const auto& entry) { return !s.tiles.contains(entry.first); });
  const bool stale = std::any_of(s.tiles.begin(), s.tiles.end(), [](const auto& entry) {
    return entry.second.stale && !entry.second.tile.count.empty();
  });
  if (s.current && !dropped && !stale) return s.current;

  auto next = std::make_shared<image::PlateSnapshot>(s.sphere);
  next->version = s.current ? s.current->version + 1 : s.options.first_version;
  if (s.current) next->tiles = s.current->tiles;
  if (dropped)
    std::erase_if(next->tiles, [&](const auto& entry) { return !s.tiles.contains(entry.first); });
  for (auto& [key, t] : s.tiles) {
    if (!t.stale || t.tile.count.empty()) continue;
    image::PlateTile out = t.tile;
    if (s.fitted && !t.seed.empty()) blend_seed(t.seed, t.zones, s.fit, s.turf, s.blend, out);
    fill_holes(s.tiles, key, s.options, out);
    next->tiles.insert_or_assign(key, std::move(out));
    t.stale = false;
  }
  s.current = std::move(next);
  return s.current;
}

}  // namespace touchline::plate
