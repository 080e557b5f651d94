#include "hub/track/side_check.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "hub/track/standing.h"
#include "hub/track/standing_internal.h"
#include "shared/base/bounds.h"

namespace touchline::track {
namespace {

constexpr double kNearby = 7;   // metres: where chance is measured
constexpr double kGrid = 1.75;  // metres between the places it is measured at
constexpr double kAlone = 1.2;  // metres: nearer than this it is the same person
constexpr double kLeastChance = 0.03;
constexpr double kMostChance = 0.9;
constexpr int kLeastChances = 4;           // places nearby that must be seen
constexpr std::size_t kMostTogether = 16;  // cameras compared at once

// What one cell of the pitch says of a pair: how often someone was found, against chance.
struct Cell {
  double found = 0;
  double chance = 0;
  double times = 0;
};
using Cells = std::map<std::pair<int, int>, Cell>;

struct Pair {
  std::array<Cells, 2> cells;  // as stated; with one of the two turned
};

Eigen::Vector3d turned(const Eigen::Vector3d& p) { return {-p.x(), -p.y(), p.z()}; }

struct Sum {
  double evidence = 0;
  int found = 0;  // cells
};

}  // namespace

base::Status SideOptions::validate() const {
  for (const base::Status& status : {base::in_bounds("found_share", found_share, 0.3, 0.99),
                                     base::in_bounds("cell_m", cell_m, 0.3, 10),
                                     base::in_bounds("least_evidence", least_evidence, 1, 100),
                                     base::in_bounds("least_places", least_places, 2, 1000)}) {
    if (!status) return status;
  }
  return {};
}

class SideCheck::Impl {
 public:
  Impl(pitch::PitchModel pitch, const SideOptions& options)
      : pitch_(std::move(pitch)), options_(options) {}

  void add(std::span<const codec::CameraView> views) {
    std::vector<std::vector<Eigen::Vector3d>> places;
    for (const codec::CameraView& view : views) {
      static_cast<void>(index_of(view.id.camera));
      std::vector<Eigen::Vector3d>& feet = places.emplace_back();
      for (const Standing& one : standing(view, pitch_)) feet.push_back(one.at);
    }
    for (std::size_t a = 0; a < views.size(); ++a) {
      for (std::size_t b = 0; b < views.size(); ++b) {
        if (a == b || !views[b].matte || views[b].estimate.lost()) continue;
        for (int turn = 0; turn < 2; ++turn) compare(views[a], places[a], views[b], turn);
      }
    }
  }

  SideReport report() const {
    SideReport out;
    const std::size_t n = cameras_.size();
    // Evidence for "one of the two is turned" less that for "as stated".
    std::vector<std::vector<double>> turn(n, std::vector<double>(n, 0));
    std::vector<std::vector<int>> places(n, std::vector<int>(n, 0));
    std::vector<std::size_t> part(n);
    std::iota(part.begin(), part.end(), std::size_t{0});
    for (const auto& [key, pair] : pairs_) {
      const auto [a, b] = key;
      const Sum stated = sum(pair.cells[0]), other = sum(pair.cells[1]);
      const double difference = other.evidence - stated.evidence;
      // Disagreement alone is no evidence: bad mattes disagree too. Someone must be found.
      const Sum& likely = difference > 0 ? other : stated;
      if (likely.evidence < options_.least_evidence || likely.found < options_.least_places)
        continue;
      if (std::abs(difference) < options_.least_evidence) continue;
      turn[a][b] = turn[b][a] = difference;
      places[a][b] = places[b][a] = likely.found;
      ++out.pairs;
      const std::size_t from = part[b], to = part[a];
      for (std::size_t& p : part) p = p == from ? to : p;
    }
    std::set<std::size_t> agreeing;
    for (const std::size_t p : std::set<std::size_t>(part.begin(), part.end())) {
      std::vector<std::size_t> members;
      for (std::size_t i = 0; i < n; ++i) {
        if (part[i] == p && members.size() < kMostTogether) members.push_back(i);
      }
      if (members.size() >= 2) judge(members, turn, places, out, agreeing);
    }
    for (const std::size_t i : agreeing) out.agreeing.push_back(cameras_[i]);
    return out;
  }

 private:
  std::size_t index_of(const base::CameraId& camera) {
    const auto at = std::find(cameras_.begin(), cameras_.end(), camera);
    const auto index = static_cast<std::size_t>(at - cameras_.begin());
    if (at == cameras_.end()) cameras_.push_back(camera);
    return index;
  }

  // Are the people whom `a` sees seen by `b`, with `a` turned or not?
  void compare(const codec::CameraView& a, const std::vector<Eigen::Vector3d>& places,
               const codec::CameraView& b, int turn) {
    const Eigen::Vector3d eye = geometry::position_in_world(a.estimate);
    const std::size_t first = index_of(a.id.camera), second = index_of(b.id.camera);
    Cells& cells = pairs_[std::minmax(first, second)].cells[static_cast<std::size_t>(turn)];
    for (const Eigen::Vector3d& place : places) {
      const Eigen::Vector2d sight = (place - eye).head<2>().normalized();
      const Eigen::Vector3d at = turn == 0 ? place : turned(place);
      const Eigen::Vector2d along = turn == 0 ? sight : Eigen::Vector2d(-sight);
      const auto found = stands(b, at, along);
      if (!found) continue;
      const auto chance = chance_near(b, at, along, places, turn);
      if (!chance) continue;
      // One person has one cell, whoever of the two is asked: that in the first one's world.
      const Eigen::Vector3d& own = first < second ? place : at;
      Cell& cell = cells[{static_cast<int>(std::floor(own.x() / options_.cell_m)),
                          static_cast<int>(std::floor(own.y() / options_.cell_m))}];
      cell.found += *found ? 1 : 0;
      cell.chance += *chance;
      ++cell.times;
    }
  }

  // How often `b` has someone round a place, where `a` claims nobody. None where too little of the
  // surroundings is seen.
  std::optional<double> chance_near(const codec::CameraView& b, const Eigen::Vector3d& place,
                                    const Eigen::Vector2d& along,
                                    const std::vector<Eigen::Vector3d>& claimed, int turn) const {
    int seen = 0, found = 0;
    for (double dx = -kNearby; dx <= kNearby; dx += kGrid) {
      for (double dy = -kNearby; dy <= kNearby; dy += kGrid) {
        if (dx * dx + dy * dy > kNearby * kNearby) continue;
        const Eigen::Vector3d at = place + Eigen::Vector3d(dx, dy, 0);
        const bool taken =
            std::any_of(claimed.begin(), claimed.end(), [&](const Eigen::Vector3d& p) {
              const Eigen::Vector3d q = turn == 0 ? p : turned(p);
              return (q - at).head<2>().squaredNorm() < kAlone * kAlone;
            });
        if (taken) continue;
        const auto there = stands(b, at, along);
        if (!there) continue;
        ++seen;
        found += *there ? 1 : 0;
      }
    }
    if (seen < kLeastChances) return std::nullopt;
    return static_cast<double>(found) / seen;
  }

  Sum sum(const Cells& cells) const {
    Sum out;
    for (const auto& [key, cell] : cells) {
      const double chance = std::clamp(cell.chance / cell.times, kLeastChance, kMostChance);
      const double hit = std::max(options_.found_share, chance);
      const double share = cell.found / cell.times;
      out.evidence +=
          share * std::log(hit / chance) + (1 - share) * std::log((1 - hit) / (1 - chance));
      if (share > 0.5) ++out.found;
    }
    return out;
  }

  // The most likely division of cameras that can be compared into those as stated and those turned.
  void judge(const std::vector<std::size_t>& members, const std::vector<std::vector<double>>& turn,
             const std::vector<std::vector<int>>& places, SideReport& out,
             std::set<std::size_t>& agreeing) const {
    const std::size_t n = members.size();
    const auto score = [&](std::uint32_t division) {
      double total = 0;
      for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = i + 1; j < n; ++j) {
          if (((division >> i) ^ (division >> j)) & 1u) total += turn[members[i]][members[j]];
        }
      }
      return total;
    };
    // Turning all of them changes nothing: the first stays.
    std::uint32_t best = 0;
    double most = 0;
    for (std::uint32_t division = 0; division < (1u << n); division += 2) {
      const double total = score(division);
      if (total > most) std::tie(most, best) = std::tuple(total, division);
    }
    if (best == 0) {
      agreeing.insert(members.begin(), members.end());
      return;
    }
    const auto count = static_cast<std::size_t>(std::popcount(best));
    const bool undecided = 2 * count == n;
    if (2 * count > n) best = ~best & ((1u << n) - 1);
    TurnedCameras found;
    found.undecided = undecided;
    found.evidence = 1e9;
    for (std::size_t i = 0; i < n; ++i) {
      const bool is_turned = ((best >> i) & 1u) != 0;
      if (!is_turned && !undecided) {
        agreeing.insert(members[i]);
        continue;
      }
      found.cameras.push_back(cameras_[members[i]]);
      found.evidence = std::min(found.evidence, most - score(best ^ (1u << i)));
      for (std::size_t j = 0; j < n; ++j) {
        if (is_turned && !((best >> j) & 1u) && turn[members[i]][members[j]] > 0)
          found.places += places[members[i]][members[j]];
      }
    }
    if (found.evidence >= options_.least_evidence) out.turned.push_back(std::move(found));
  }

  pitch::PitchModel pitch_;
  SideOptions options_;
  std::vector<base::CameraId> cameras_;  // in the order they came
  std::map<std::pair<std::size_t, std::size_t>, Pair> pairs_;
};

SideCheck::SideCheck(pitch::PitchModel pitch, const SideOptions& options)
    : impl_(std::make_unique<Impl>(std::move(pitch), options)) {}
SideCheck::SideCheck(SideCheck&&) noexcept = default;
SideCheck& SideCheck::operator=(SideCheck&&) noexcept = default;
SideCheck::~SideCheck() = default;

void SideCheck::add(std::span<const codec::CameraView> views) { impl_->add(views); }
SideReport SideCheck::report() const { return impl_->report(); }

}  // namespace touchline::track
