// Everything that rays may hit between two times, and where on the turf shadows may fall.
#pragma once

#include <embree3/rtcore.h>

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "tools/sim/people/cast.h"
#include "tools/sim/world/lanes.h"
#include "tools/sim/world/world_data.h"

namespace touchline::sim::render {

// Embree's objects, released with their owner.
template <typename T, void (*kRelease)(T)>
class Owned {
 public:
  Owned() = default;
  explicit Owned(T object) : object_(object) {}
  ~Owned() {
    if (object_) kRelease(object_);
  }
  Owned(Owned&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  Owned& operator=(Owned&& other) noexcept {
    std::swap(object_, other.object_);
    return *this;
  }
  Owned(const Owned&) = delete;
  Owned& operator=(const Owned&) = delete;
  T get() const { return object_; }

 private:
  T object_ = nullptr;
};
using Device = Owned<RTCDevice, rtcReleaseDevice>;
using Scene = Owned<RTCScene, rtcReleaseScene>;

// One person or the ball, from when the shutter opens until it closes.
struct Figure {
  const people::Body* body = nullptr;
  people::Posture open, close;  // close is empty when nothing moves
};

// Whether a lamp reaches a square of turf: wholly, not at all, or to be asked with rays against
// what stands there or against people.
struct CellLight {
  bool dark = false;
  bool ask_ground = false;
  bool ask_figures = false;
};

// What all lamps do to a square of turf: a bit a lamp.
inline constexpr unsigned kAskBits = 8;   // ask with rays, from this bit on
inline constexpr unsigned kNearBit = 16;  // people leave less of the sky's light
inline constexpr std::size_t kSummedLamps = 8;

// Squares of turf under one lamp.
class LightCells {
 public:
  LightCells() = default;
  LightCells(float half_x, float half_y);
  CellLight at(float x, float y) const {
    const float u = (x + half_x_) * kPerMetre, v = (y + half_y_) * kPerMetre;
    if (!(u >= 0 && v >= 0 && u < static_cast<float>(width_) && v < static_cast<float>(height_)))
      return {false, true, true};
    return cells_[static_cast<std::size_t>(static_cast<int>(v) * width_ + static_cast<int>(u))];
  }
  // Marks a rectangle.
  void ask_ground(float x0, float y0, float x1, float y1) { mark(x0, y0, x1, y1, false); }
  void ask_figures(float x0, float y0, float x1, float y1) { mark(x0, y0, x1, y1, true); }
  // From what rays found at the corners of all cells, (width + 1) by (height + 1).
  void fill(const std::vector<std::uint8_t>& dark_corners);
  // Places of eight points in rows of squares; lanes outside are not in `inside`.
  world::Ints index(world::Floats x, world::Floats y, world::Floats& inside) const {
    using namespace world;  // NOLINT: arithmetic of lanes
    const Floats u = (x + all(half_x_)) * all(kPerMetre), v = (y + all(half_y_)) * all(kPerMetre);
    inside = both(both(at_most(all(0), u), at_most(all(0), v)),
                  both(below(u, all(static_cast<float>(width_))),
                       below(v, all(static_cast<float>(height_)))));
    return _mm256_add_epi32(_mm256_mullo_epi32(whole(both(inside, v)), all_ints(width_)),
                            whole(both(inside, u)));
  }
  CellLight at(std::size_t index) const { return cells_[index]; }
  std::size_t size() const { return cells_.size(); }
  int width() const { return width_; }
  int height() const { return height_; }
  float corner_x(int i) const { return static_cast<float>(i) / kPerMetre - half_x_; }
  float corner_y(int j) const { return static_cast<float>(j) / kPerMetre - half_y_; }

 private:
  static constexpr float kPerMetre = 2;
  void mark(float x0, float y0, float x1, float y1, bool figures);
  float half_x_ = 0, half_y_ = 0;
  int width_ = 0, height_ = 0;
  std::vector<CellLight> cells_;
};

// Geometry identifiers in the scene: solids, then tiers and roofs by side, then figures.
inline constexpr unsigned kSolidGeometry = 0;
inline constexpr unsigned kTierGeometry = 1;
inline constexpr unsigned kRoofGeometry = kTierGeometry + world::kSides;
inline constexpr unsigned kFigureGeometry = kRoofGeometry + world::kSides;
std::uint32_t geometry_mask(unsigned geometry);  // what rays' masks let through

// The ground without people; made once.
class Ground {
 public:
  explicit Ground(std::shared_ptr<const world::WorldData> world);
  const world::WorldData& world() const { return *world_; }
  RTCDevice device() const { return device_.get(); }
  RTCScene scene() const { return scene_.get(); }
  const world::SolidMesh& mesh(unsigned geometry) const;
  // For the lamps of world.light.at(any time), in their order (the sun first where there is one).
  const std::vector<LightCells>& cells() const { return cells_; }
  const std::vector<world::Lamp>& lamps() const { return lamps_; }

 private:
  void build();
  void bake();
  std::shared_ptr<const world::WorldData> world_;
  Device device_;
  Scene scene_;
  std::vector<std::vector<float>> vertices_;  // of each geometry, padded as Embree wants it
  std::vector<world::Lamp> lamps_;
  std::vector<LightCells> cells_;
};

class Moment {
 public:
  Moment(const Ground& ground, const people::Cast* cast, double open_s, double close_s);
  RTCScene scene() const { return scene_.get(); }  // of the figures alone
  const std::vector<Figure>& figures() const { return figures_; }
  const std::vector<LightCells>& cells() const { return cells_; }
  bool near_figure(float x, float y) const { return contact_.at(x, y).ask_figures; }
  // Bits of all lamps (those of Ground::lamps()) for eight places; lanes outside have all asked.
  world::Ints summary(world::Floats x, world::Floats y) const;
  // What people leave of the sky's light at a place of the turf near them.
  float contact_shade(float x, float y) const;

 private:
  void mark_shadows(const Ground& ground);
  void sum_up();
  Scene scene_;
  std::vector<Figure> figures_;
  std::vector<LightCells> cells_;
  LightCells contact_;
  std::vector<std::uint32_t> summary_;  // of each square
  struct Contact {
    float x, y, strength, per_square;
  };
  std::vector<Contact> contacts_;
};

}  // namespace touchline::sim::render
