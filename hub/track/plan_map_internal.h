// A hull group seen from above: how much of it stands over each place, and which summits it has.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "shared/geometry/mesh.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::track {

// Part of a plan that belongs to one person.
struct PlanPart {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  // of its mass
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();  // second central moments, m^2
  double volume_m3 = 0;
};

class PlanMap {
 public:
  static constexpr double kCell = 0.05;  // metres

  // Mass is the volume between two heights above the turf. The mesh is closed, its triangles are
  // small against a cell.
  PlanMap(const geometry::Mesh& mesh, const pitch::PitchModel& pitch, double low_m, double high_m);

  // One part a summit. A summit counts when it stands out by a quarter of its height above the pass
  // to the next, and lies half a metre from it.
  std::vector<PlanPart> parts() const;
  // One part a given place: each cell goes to the nearest.
  std::vector<PlanPart> parts_of(std::span<const Eigen::Vector2d> places) const;
  // Distance from a place to the nearest cell with mass.
  double distance(const Eigen::Vector2d& place) const;

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x);
  }
  Eigen::Vector2d centre(int x, int y) const {
    return origin_ + kCell * Eigen::Vector2d(x + 0.5, y + 0.5);
  }
  std::vector<PlanPart> gather(const std::vector<int>& owner, std::size_t count) const;

  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  int width_ = 0;
  int height_ = 0;
  std::vector<double> mass_;  // m^3 over each cell
};

}  // namespace touchline::track
