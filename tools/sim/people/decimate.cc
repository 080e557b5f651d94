#include "tools/sim/people/decimate.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <queue>

namespace touchline::sim::people {
namespace {

// Symmetric 4x4 form of squared distances to planes.
struct Quadric {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  double c = 0;
  void add_plane(const Eigen::Vector3d& n, double d, double w) {
    a += w * n * n.transpose();
    b += w * d * n;
    c += w * d * d;
  }
  void add(const Quadric& o) {
    a += o.a;
    b += o.b;
    c += o.c;
  }
  double at(const Eigen::Vector3d& p) const { return p.dot(a * p) + 2 * b.dot(p) + c; }
};

struct Candidate {
  double cost;
  std::uint32_t from, to;
  std::uint32_t stamp;
  bool operator<(const Candidate& o) const {  // for a queue that gives the least first
    if (cost != o.cost) return cost > o.cost;
    if (from != o.from) return from > o.from;
    return to > o.to;
  }
};

class Collapser {
 public:
  Collapser(const std::vector<Eigen::Vector3f>& vertices,
            const std::vector<std::array<std::uint32_t, 3>>& triangles,
            const std::vector<float>& importance)
      : importance_(importance), triangles_(triangles), alive_(triangles.size(), true) {
    points_.reserve(vertices.size());
    for (const auto& v : vertices) points_.push_back(v.cast<double>());
    quadrics_.resize(points_.size());
    around_.resize(points_.size());
    stamp_.assign(points_.size(), 0);
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      const auto& [i, j, k] = triangles_[t];
      const Eigen::Vector3d cross = (points_[j] - points_[i]).cross(points_[k] - points_[i]);
      const double area = cross.norm();
      for (const std::uint32_t v : triangles_[t]) {
        around_[v].push_back(t);
        if (area > 0) {
          const Eigen::Vector3d n = cross / area;
          quadrics_[v].add_plane(n, -n.dot(points_[i]), area);
        }
      }
    }
  }

  void run(std::size_t target) {
    std::size_t count = triangles_.size();
    for (std::uint32_t v = 0; v < points_.size(); ++v) push(v);
    while (count > target && !queue_.empty()) {
      const Candidate best = queue_.top();
      queue_.pop();
      if (stamp_[best.from] != best.stamp || around_[best.from].empty()) continue;
      if (!legal(best.from, best.to)) continue;
      count -= collapse(best.from, best.to);
    }
  }

  Decimated result() const {
    Decimated out;
    std::vector<std::uint32_t> place(points_.size(), 0);
    std::vector<bool> used(points_.size(), false);
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      if (!alive_[t]) continue;
      for (const std::uint32_t v : triangles_[t]) used[v] = true;
    }
    for (std::uint32_t v = 0; v < points_.size(); ++v) {
      if (!used[v]) continue;
      place[v] = static_cast<std::uint32_t>(out.kept.size());
      out.kept.push_back(v);
    }
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      if (!alive_[t]) continue;
      const auto& [i, j, k] = triangles_[t];
      out.triangles.push_back({place[i], place[j], place[k]});
    }
    return out;
  }

 private:
  std::vector<std::uint32_t> neighbours(std::uint32_t v) const {
    std::vector<std::uint32_t> out;
    for (const std::uint32_t t : around_[v]) {
      for (const std::uint32_t w : triangles_[t]) {
        if (w != v) out.push_back(w);
      }
    }
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
  }

  void push(std::uint32_t v) {
    for (const std::uint32_t w : neighbours(v)) {
      Quadric sum = quadrics_[v];
      sum.add(quadrics_[w]);
      const double shape = 1e-4 * (points_[v] - points_[w]).squaredNorm();
      queue_.push(
          {(std::max(0.0, sum.at(points_[w])) + shape * shape) * importance_[v], v, w, stamp_[v]});
    }
  }

  // Two common neighbours (else the surface pinches), and no triangle turns over.
  bool legal(std::uint32_t from, std::uint32_t to) const {
    const auto a = neighbours(from);
    const auto b = neighbours(to);
    std::vector<std::uint32_t> common;
    std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
    if (common.size() != 2 || !std::binary_search(a.begin(), a.end(), to)) return false;
    if (a.size() + b.size() < 8) return false;
    for (const std::uint32_t t : around_[from]) {
      std::array<Eigen::Vector3d, 3> before;
      std::array<Eigen::Vector3d, 3> after;
      bool falls = false;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t v = triangles_[t][i];
        falls |= v == to;
        before[i] = points_[v];
        after[i] = points_[v == from ? to : v];
      }
      if (falls) continue;
      const Eigen::Vector3d n0 = (before[1] - before[0]).cross(before[2] - before[0]);
      const Eigen::Vector3d n1 = (after[1] - after[0]).cross(after[2] - after[0]);
      if (n0.dot(n1) < 0.15 * n0.norm() * n1.norm()) return false;
    }
    return true;
  }

  std::size_t collapse(std::uint32_t from, std::uint32_t to) {
    std::size_t gone = 0;
    for (const std::uint32_t t : around_[from]) {
      auto& triangle = triangles_[t];
      if (std::find(triangle.begin(), triangle.end(), to) != triangle.end()) {
        for (const std::uint32_t v : triangle) {
          if (v != from) std::erase(around_[v], t);
        }
        alive_[t] = false;
        ++gone;
      } else {
        std::replace(triangle.begin(), triangle.end(), from, to);
        around_[to].push_back(t);
      }
    }
    around_[from].clear();
    quadrics_[to].add(quadrics_[from]);
    ++stamp_[to];
    push(to);
    for (const std::uint32_t v : neighbours(to)) {
      ++stamp_[v];
      push(v);
    }
    return gone;
  }

  const std::vector<float>& importance_;
  std::vector<std::array<std::uint32_t, 3>> triangles_;
  std::vector<bool> alive_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<Quadric> quadrics_;
  std::vector<std::vector<std::uint32_t>> around_;
  std::vector<std::uint32_t> stamp_;
  std::priority_queue<Candidate> queue_;
};

}  // namespace

Decimated decimate(const std::vector<Eigen::Vector3f>& vertices,
                   const std::vector<std::array<std::uint32_t, 3>>& triangles,
                   const std::vector<float>& importance, std::size_t target) {
  Collapser collapser(vertices, triangles, importance);
  collapser.run(target);
  return collapser.result();
}

}  // namespace touchline::sim::people
