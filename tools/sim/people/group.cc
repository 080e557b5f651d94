#include "tools/sim/people/group.h"

#include <cmath>
#include <numbers>
#include <string>

#include "tools/sim/people/random.h"

namespace touchline::sim::people {

std::vector<GroupMember> members_of(const GroupSpec& group, double duration_s, std::uint64_t seed) {
  const Stream random(seed, "group " + group.prefix);
  const double angle = group.facing_deg * std::numbers::pi / 180;
  const Eigen::Vector2d ahead(std::cos(angle), std::sin(angle));
  const Eigen::Vector2d left(-ahead.y(), ahead.x());
  std::vector<GroupMember> out;
  for (int k = 0; k < group.people; ++k) {
    const auto u = [&](int i, double most) {
      return random.uniform(static_cast<std::uint64_t>(100 * k + i), -most, most);
    };
    GroupMember m;
    PersonSpec& p = m.person;
    p.id = group.prefix + std::to_string(k + 1);
    p.number = k + 2;
    p.facing = Facing::kFixed;
    const auto team = [&](int i) {
      return group.teams[static_cast<std::size_t>(i) % group.teams.size()];
    };
    switch (group.kind) {
      case GroupKind::kWall: {
        p.team = team(0);
        const double across = (k - 0.5 * (group.people - 1)) * 0.46 * group.spread;
        p.position_m = group.position_m + across * left + u(0, 0.03) * ahead;
        p.facing_deg = group.facing_deg + u(1, 5);
        m.hold = Hold::kWall;
        break;
      }
      case GroupKind::kRuck: {
        // One holds the ball on the turf; two packs lean on each other over him, rows of three.
        const bool down = group.people >= 4 && k == group.people - 1;
        const int side = k % 2;
        const int place = k / 2;
        p.team = team(down ? 0 : side);
        const double sign = side == 0 ? 1.0 : -1.0;
        constexpr std::array<double, 3> kAcross{0.0, 1.0, -1.0};
        const double row = place / 3;
        const double across =
            (kAcross[static_cast<std::size_t>(place % 3)] * 0.48 + 0.14 * sign) * group.spread;
        const double back = (0.62 + 0.62 * row) * group.spread;
        p.position_m = group.position_m - sign * back * ahead + across * left + u(0, 0.04) * ahead;
        p.facing_deg = group.facing_deg + (side == 0 ? 0 : 180) + u(1, 8) -
                       sign * 8 * kAcross[static_cast<std::size_t>(place % 3)];
        m.hold = Hold::kRuck;
        if (down) {
          p.position_m = group.position_m + 0.1 * left;
          p.facing_deg = group.facing_deg + 75;
          m.hold = Hold::kRuckDown;
        }
        break;
      }
      case GroupKind::kGoalMouth: {
        // The keeper in the middle of a ring, everyone up for the same ball again and again.
        p.team = k == 0 ? team(0) : team(k);
        p.role = k == 0 ? Role::kKeeper : Role::kPlayer;
        p.number = k == 0 ? 1 : k + 2;
        const double ring = k <= 5 ? 0.58 : 1.1;
        const double round =
            k <= 5 ? 2 * std::numbers::pi * k / 5.0 : 2 * std::numbers::pi * (k + 0.5) / 10.0;
        if (k > 0) {
          p.position_m = Eigen::Vector2d(std::cos(round), std::sin(round)) * ring * group.spread +
                         Eigen::Vector2d(u(0, 0.06), u(2, 0.06));
        }
        p.position_m += group.position_m;
        p.facing_deg = group.facing_deg + u(1, 25);
        for (double t = 1.0; t < duration_s + 1; t += 4.0) {
          const double start = t + (k == 0 ? 0.0 : u(static_cast<int>(10 + t), 0.25));
          if (k == 0) {
            p.actions.push_back({"catch_high", start, false, std::nullopt});
          } else if (k % 3 != 0) {
            p.actions.push_back({"header_jump", start, k % 2 == 0, std::nullopt});
          }
        }
        break;
      }
    }
    out.push_back(std::move(m));
  }
  return out;
}

}  // namespace touchline::sim::people
