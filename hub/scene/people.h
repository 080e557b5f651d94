// Who stands where, for one instant.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

namespace touchline::scene {

struct Person {
  std::string id;    // stable over the shot, e.g. "p07"; "ball" for the ball
  std::string team;  // "A", "B", "REF" or empty where it is not known
  std::string role;  // "player", "goalkeeper", "referee", "assistant", "ball" or empty
  Eigen::Vector3d position_in_world =
      Eigen::Vector3d::Zero();  // ground point under the pelvis; the ball's centre
  double sd_x_m = 0;
  double sd_y_m = 0;
  std::vector<std::uint32_t> groups;  // hull groups it is part of
};

}  // namespace touchline::scene
