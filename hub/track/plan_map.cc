#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "hub/track/plan_map_internal.h"

namespace touchline::track {

namespace {

constexpr double kSmoothing = 0.15;   // metres, standard deviation
constexpr double kProminence = 0.25;  // share of a summit's height
constexpr double kLeastApart = 0.5;   // metres between summits
constexpr double kLeastSummit = 0.3;  // share of the highest

}  // namespace

PlanMap::PlanMap(const geometry::Mesh& mesh, const pitch::PitchModel& pitch, double low_m,
                 double high_m) {
  if (mesh.vertices.empty()) return;
  Eigen::Vector2f low = mesh.vertices.front().head<2>();
  Eigen::Vector2f high = low;
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    low = low.cwiseMin(vertex.head<2>());
    high = high.cwiseMax(vertex.head<2>());
  }
  origin_ = (low.cast<double>() / kCell).array().floor() * kCell;
  width_ = static_cast<int>((high.x() - origin_.x()) / kCell) + 1;
  height_ = static_cast<int>((high.y() - origin_.y()) / kCell) + 1;
  mass_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0);
  // Gauss: the volume over a cell is the flux of the height through the surface over it.
  for (const auto& triangle : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[triangle[0]].cast<double>();
    const Eigen::Vector3d b = mesh.vertices[triangle[1]].cast<double>();
    const Eigen::Vector3d c = mesh.vertices[triangle[2]].cast<double>();
    const double up = (b - a).cross(c - a).z() / 2;
    const Eigen::Vector3d middle = (a + b + c) / 3;
    const double above = middle.z() - pitch.turf_z(middle.y());
    const int x = static_cast<int>((middle.x() - origin_.x()) / kCell);
    const int y = static_cast<int>((middle.y() - origin_.y()) / kCell);
    mass_[index(x, y)] += up * (std::clamp(above, low_m, high_m) - low_m);
  }
}

std::vector<PlanPart> PlanMap::gather(const std::vector<int>& owner, std::size_t count) const {
  std::vector<PlanPart> parts(count);
  for (int pass = 0; pass < 2; ++pass) {
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        const double mass = mass_[index(x, y)];
        const int to = owner[index(x, y)];
        if (mass <= 0 || to < 0) continue;
        PlanPart& part = parts[static_cast<std::size_t>(to)];
        if (pass == 0) {
          part.volume_m3 += mass;
          part.centre += mass * centre(x, y);
        } else {
          const Eigen::Vector2d away = centre(x, y) - part.centre;
          part.spread += (mass / part.volume_m3) * away * away.transpose();
        }
      }
    }
    if (pass > 0) continue;
    for (PlanPart& part : parts) {
      if (part.volume_m3 > 0) part.centre /= part.volume_m3;
    }
  }
  std::erase_if(parts, [](const PlanPart& part) { return part.volume_m3 <= 0; });
  return parts;
}

std::vector<PlanPart> PlanMap::parts() const {
  if (mass_.empty()) return {};
  // Smooth, separably.
  const int reach = static_cast<int>(std::ceil(3 * kSmoothing / kCell));
  std::vector<double> kernel;
  for (int i = -reach; i <= reach; ++i) {
    const double t = i * kCell / kSmoothing;
    kernel.push_back(std::exp(-t * t / 2));
  }
  std::vector<double> across(mass_.size());
  std::vector<double> smooth(mass_.size());
  const auto blur = [&](const std::vector<double>& from, std::vector<double>& to, int dx, int dy) {
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        double sum = 0;
        for (int i = -reach; i <= reach; ++i) {
          const int xx = x + i * dx;
          const int yy = y + i * dy;
          if (xx < 0 || yy < 0 || xx >= width_ || yy >= height_) continue;
          sum += kernel[static_cast<std::size_t>(i + reach)] * std::max(from[index(xx, yy)], 0.0);
        }
        to[index(x, y)] = sum;
      }
    }
  };
  blur(mass_, across, 1, 0);
  blur(across, smooth, 0, 1);

  // From the highest cell down, hills grow and meet; at a pass the lower one joins the higher
  // unless it stands out.
  std::vector<int> order(mass_.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return smooth[static_cast<std::size_t>(a)] > smooth[static_cast<std::size_t>(b)];
  });
  struct Hill {
    int summit;
    int joined;  // to this hill; itself while it stands
  };
  std::vector<Hill> hills;
  std::vector<int> owner(mass_.size(), -1);
  const auto standing = [&](int hill) {
    while (hills[static_cast<std::size_t>(hill)].joined != hill) {
      hill = hills[static_cast<std::size_t>(hill)].joined;
    }
    return hill;
  };
  const auto height_of = [&](int hill) {
    return smooth[static_cast<std::size_t>(hills[static_cast<std::size_t>(hill)].summit)];
  };
  const auto place_of = [&](int hill) {
    const int cell = hills[static_cast<std::size_t>(hill)].summit;
    return centre(cell % width_, cell / width_);
  };
  const double highest = smooth[static_cast<std::size_t>(order.front())];
  for (const int cell : order) {
    const double level = smooth[static_cast<std::size_t>(cell)];
    if (level <= 0) break;
    const int x = cell % width_;
    const int y = cell / width_;
    int best = -1;
    for (int n = 0; n < 9; ++n) {
      const int xx = x + n % 3 - 1;
      const int yy = y + n / 3 - 1;
      if (xx < 0 || yy < 0 || xx >= width_ || yy >= height_ || owner[index(xx, yy)] < 0) continue;
      const int hill = standing(owner[index(xx, yy)]);
      if (best < 0 || best == hill) {
        best = hill;
        continue;
      }
      const int higher = height_of(best) >= height_of(hill) ? best : hill;
      const int lower = higher == best ? hill : best;
      const double top = height_of(lower);
      const bool stands_out = top - level >= kProminence * top && top >= kLeastSummit * highest &&
                              (place_of(lower) - place_of(higher)).norm() >= kLeastApart;
      if (!stands_out) hills[static_cast<std::size_t>(lower)].joined = higher;
      best = higher;
    }
    if (best < 0) {
      best = static_cast<int>(hills.size());
      hills.push_back({cell, best});
    }
    owner[static_cast<std::size_t>(cell)] = best;
  }
  std::vector<int> number(hills.size(), -1);
  int count = 0;
  for (std::size_t h = 0; h < hills.size(); ++h) {
    const auto root = static_cast<std::size_t>(standing(static_cast<int>(h)));
    if (number[root] < 0) number[root] = count++;
    number[h] = number[root];
  }
  for (int& of : owner) {
    if (of >= 0) of = number[static_cast<std::size_t>(of)];
  }
  return gather(owner, static_cast<std::size_t>(count));
}

std::vector<PlanPart> PlanMap::parts_of(std::span<const Eigen::Vector2d> places) const {
  std::vector<int> owner(mass_.size(), -1);
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      double nearest = std::numeric_limits<double>::infinity();
      for (std::size_t p = 0; p < places.size(); ++p) {
        const double away = (centre(x, y) - places[p]).squaredNorm();
        if (away < nearest) {
          nearest = away;
          owner[index(x, y)] = static_cast<int>(p);
        }
      }
    }
  }
  return gather(owner, places.size());
}

double PlanMap::distance(const Eigen::Vector2d& place) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      if (mass_[index(x, y)] > 0) nearest = std::min(nearest, (centre(x, y) - place).norm());
    }
  }
  return nearest;
}

}  // namespace touchline::track
