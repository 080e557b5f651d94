// What of a person or the ball does not change over time: triangles and paint.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace touchline::sim::people {

class Paint;  // colour by place on the body; internal

// Triangles wind counter-clockwise seen from outside; closed surface; constant over time. All
// functions are pure and may be called from several threads.
struct Body {
  std::string id;    // as in people.csv; the ball's is "ball"
  std::string team;  // "" for the ball
  std::string role;  // "player", "goalkeeper", "referee", "ball"
  std::size_t vertices = 0;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::shared_ptr<const Paint> paint;

  // Diffuse reflectance (linear BT.709) at p = (1-u-v) a + u b + v c of triangle (a, b, c).
  Eigen::Vector3f albedo(std::uint32_t triangle, float u, float v) const;
  // 0 mirror .. 1 matt, for a faint sheen (skin 0.55, cloth 0.9, boots 0.35, ball 0.4).
  float roughness(std::uint32_t triangle, float u, float v) const;
};

}  // namespace touchline::sim::people
