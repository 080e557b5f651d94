#include "tools/score/hull_score.h"

#include <oneapi/tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

#include "hub/hull/carve.h"
#include "tools/score/mesh_query.h"
#include "tools/score/oracle.h"
#include "tools/score/score_context.h"

namespace touchline::score {

namespace {

constexpr std::size_t kLeastVertices = 100;

std::uint32_t root_of(std::vector<std::uint32_t>& parent, std::uint32_t node) {
  while (parent[node] != node) {
    parent[node] = parent[parent[node]];
    node = parent[node];
  }
  return node;
}

const ScoreKind kLeast{"hull", "inside, least person", "%", Better::kHigher, Statistic::kMean, 2};
const ScoreKind kMean{"hull", "inside, mean of people", "%", Better::kHigher, Statistic::kMean, 2};
const ScoreKind kAll{"hull", "inside, all vertices", "%", Better::kHigher, Statistic::kMean, 3};
const ScoreKind kPerson{"hull", "inside by person", "%", Better::kHigher, Statistic::kMean, 2};
const ScoreKind kVolume{"hull", "volume over true mattes' hull", "", Better::kOne, Statistic::kMean,
                        3};
const ScoreKind kPhantoms{"hull", "phantoms a frame", "", Better::kLower, Statistic::kMean, 2};

struct FrameResult {
  base::Status status;
  HullScore score;
  double true_volume_m3 = 0;  // of the hull of the true mattes; 0 where there is none
};

FrameResult score_frame(const Context& context, std::int64_t frame,
                        const std::vector<codec::CameraView>& true_views) {
  FrameResult result;
  const auto hull = read_ply(numbered(context.options.exports / "hull", frame, ".ply"));
  const auto mesh = hull ? context.truth.mesh(frame) : hull;
  if (!mesh) {
    result.status = base::fail(mesh.error());
    return result;
  }
  result.score = score_hull(*hull, *mesh, context.truth.people(frame), context.cameras(frame),
                            context.options.voxel_m);
  hull::HullOptions options;
  options.dilation_px = context.options.dilation_px;
  options.voxel_m = std::clamp(context.options.voxel_m, 0.005, 0.2);
  for (const scene::HullGroup& group :
       hull::carve(true_views, context.pitch, options).hull.groups) {
    if (!group.phantom) result.true_volume_m3 += volume_m3(group.surface);
  }
  return result;
}

}  // namespace

double volume_m3(const geometry::Mesh& mesh) {
  if (mesh.vertices.empty()) return 0;
  const Eigen::Vector3d base = mesh.vertices.front().cast<double>();
  double six = 0;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[t[0]].cast<double>() - base;
    const Eigen::Vector3d b = mesh.vertices[t[1]].cast<double>() - base;
    const Eigen::Vector3d c = mesh.vertices[t[2]].cast<double>() - base;
    six += a.dot(b.cross(c));
  }
  return six / 6;
}

double HullScore::least_share() const {
  double least = 1;
  for (const PersonInside& person : people) least = std::min(least, person.share);
  return people.empty() ? 0 : least;
}

double HullScore::mean_share() const {
  double sum = 0;
  for (const PersonInside& person : people) sum += person.share;
  return people.empty() ? 0 : sum / static_cast<double>(people.size());
}

std::vector<geometry::Mesh> split_components(const geometry::Mesh& mesh) {
  std::vector<std::uint32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0U);
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 1; i < 3; ++i) {
      const std::uint32_t a = root_of(parent, t[0]);
      const std::uint32_t b = root_of(parent, t[i]);
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  std::vector<geometry::Mesh> parts;
  constexpr std::uint32_t kNone = 0xFFFFFFFF;
  std::vector<std::uint32_t> part_of(mesh.vertices.size(), kNone);
  std::vector<std::uint32_t> number(mesh.vertices.size(), kNone);
  for (const auto& t : mesh.triangles) {
    const std::uint32_t root = root_of(parent, t[0]);
    if (part_of[root] == kNone) {
      part_of[root] = static_cast<std::uint32_t>(parts.size());
      parts.emplace_back();
    }
    geometry::Mesh& part = parts[part_of[root]];
    std::array<std::uint32_t, 3> triangle{};
    for (std::size_t i = 0; i < 3; ++i) {
      if (number[t[i]] == kNone) {
        number[t[i]] = static_cast<std::uint32_t>(part.vertices.size());
        part.vertices.push_back(mesh.vertices[t[i]]);
      }
      triangle[i] = number[t[i]];
    }
    part.triangles.push_back(triangle);
  }
  return parts;
}

HullScore score_hull(const geometry::Mesh& hull, const geometry::Mesh& truth,
                     const std::vector<TruePerson>& people,
                     std::span<const geometry::CameraEstimate> cameras, double reach_m) {
  HullScore score;
  std::vector<geometry::Mesh> parts = split_components(hull);  // without inner walls of hollows
  std::erase_if(parts, [](const geometry::Mesh& part) { return volume_m3(part) <= 0; });
  score.components = parts.size();
  score.volume_m3 = volume_m3(hull);
  std::vector<MeshQuery> queries(parts.size());
  std::vector<Eigen::AlignedBox3d> boxes(parts.size());
  for (std::size_t p = 0; p < parts.size(); ++p) {
    queries[p].add(parts[p]);
    for (const Eigen::Vector3f& v : parts[p].vertices) boxes[p].extend(v.cast<double>());
    boxes[p].min().array() -= reach_m;
    boxes[p].max().array() += reach_m;
  }
  std::vector<bool> touched(parts.size(), false);
  const std::vector<int> owner = assign_vertices(truth, people);
  std::vector<std::size_t> seen(people.size());
  std::vector<std::size_t> inside(people.size());
  std::size_t all_seen = 0;
  std::size_t all_inside = 0;
  for (std::size_t i = 0; i < truth.vertices.size(); ++i) {
    const Eigen::Vector3d point = truth.vertices[i].cast<double>();
    bool held = false;
    for (std::size_t p = 0; p < parts.size(); ++p) {
      if (!boxes[p].contains(point)) continue;
      if (queries[p].inside(point) || queries[p].distance(point, reach_m) < reach_m) {
        held = true;
        touched[p] = true;
      }
    }
    const auto by = std::count_if(cameras.begin(), cameras.end(), [&](const auto& camera) {
      const auto pixel = geometry::project(camera, point);
      return pixel && camera.model.sees(*pixel);
    });
    if (by < 2) continue;
    ++all_seen;
    all_inside += held;
    if (owner[i] < 0) continue;
    ++seen[static_cast<std::size_t>(owner[i])];
    inside[static_cast<std::size_t>(owner[i])] += held;
  }
  score.vertices = all_seen;
  score.all_share =
      all_seen > 0 ? static_cast<double>(all_inside) / static_cast<double>(all_seen) : 0;
  score.phantoms = static_cast<std::size_t>(std::count(touched.begin(), touched.end(), false));
  for (std::size_t p = 0; p < people.size(); ++p) {
    if (seen[p] < (people[p].is_ball() ? 1 : kLeastVertices)) continue;
    score.people.push_back(
        {people[p].id, static_cast<double>(inside[p]) / static_cast<double>(seen[p]), seen[p]});
  }
  return score;
}

base::Status score_hulls(const Context& context, SeriesBook& book, Remarks& remarks) {
  const auto folder = context.options.exports / "hull";
  if (!is_there(folder)) {
    remarks.not_scored.push_back(fmt::format("hull: no {}", folder.string()));
    return {};
  }
  std::vector<std::int64_t> frames = context.truth.mesh_frames();
  if (frames.empty()) {
    remarks.not_scored.push_back("hull: the truth has no mesh");
    return {};
  }
  const std::size_t all = frames.size();
  std::erase_if(frames, [&](std::int64_t f) { return !is_there(numbered(folder, f, ".ply")); });
  if (frames.size() < all) {
    remarks.not_scored.push_back(
        fmt::format("hull: {} of {} frames with a true mesh were not "
                    "exported",
                    all - frames.size(), all));
  }
  if (!context.truth.has_people()) {
    remarks.not_scored.push_back("hull by person: the truth has no people.csv");
  }
  frames = spread(frames, context.options.most_hulls);
  OracleOptions oracle_options;
  oracle_options.tiles = false;
  auto oracle = Oracle::open(context.recording, context.truth, oracle_options);
  if (!oracle) return base::fail(oracle.error());
  std::vector<std::vector<codec::CameraView>> true_views(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    oracle->skip_to(frames[i]);
    auto views = oracle->next();
    if (!views) return base::fail(views.error());
    if (*views) true_views[i] = std::move(**views);
  }
  std::vector<FrameResult> results(frames.size());
  tbb::parallel_for(std::size_t{0}, frames.size(), [&](std::size_t i) {
    results[i] = score_frame(context, frames[i], true_views[i]);
    true_views[i].clear();
  });
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!results[i].status) return base::fail(results[i].status.error());
    const HullScore& s = results[i].score;
    const std::int64_t frame = frames[i];
    if (!s.people.empty()) {
      book.add(kLeast, "all", {frame, 100 * s.least_share()});
      book.add(kMean, "all", {frame, 100 * s.mean_share()});
    }
    if (s.vertices > 0) {
      book.add(kAll, "all", {frame, 100 * s.all_share, static_cast<double>(s.vertices)});
    }
    if (results[i].true_volume_m3 > 0) {
      book.add(kVolume, "all",
               {frame, s.volume_m3 / results[i].true_volume_m3, results[i].true_volume_m3});
    }
    book.add(kPhantoms, "all", {frame, static_cast<double>(s.phantoms)});
    for (const PersonInside& person : s.people) {
      book.add_person(kPerson, person.person,
                      {frame, 100 * person.share, static_cast<double>(person.vertices)});
    }
  }
  return {};
}

}  // namespace touchline::score
