// Hull and people. Peer of the hull: a plain loop over every voxel of a box round each person,
// whose places it is told for nothing, with masks dilated by OpenCV; it has no unknown, no support
// rule and no surfaces. Peers of the surface: VTK's flying edges and marching cubes on the same
// samples.
#include <oneapi/tbb/global_control.h>

#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "hub/hull/carve.h"
#include "hub/hull/surface_internal.h"
#include "hub/hull/volume_internal.h"
#include "hub/track/people_tracker.h"
#include "tests/bench/bench.h"
#include "tests/bench/input.h"
#ifdef TOUCHLINE_BENCH_VTK
#include "tests/bench/vtk_peer.h"
#endif

namespace touchline::bench {
namespace {

constexpr int kCameras = 12;
constexpr int kPeople = 22;
constexpr double kVoxel = 0.02;

const std::vector<codec::CameraView>& views(Size size) {
  static std::map<Size, std::vector<codec::CameraView>> cache;
  auto& made = cache[size];
  if (made.empty()) made = smoke() ? crowd(4, 3, size) : crowd(kCameras, kPeople, size);
  return made;
}
const std::vector<Eigen::Vector2d>& places() {
  static const auto made = crowd_places(smoke() ? 3 : kPeople);
  return made;
}

using Cores = oneapi::tbb::global_control;
constexpr auto kMost = Cores::max_allowed_parallelism;

void hull(benchmark::State& state, const std::vector<codec::CameraView>& in, std::size_t cores) {
  const Cores limit(kMost, cores);
  hull::HullResult result;
  state.counters["peak_mib"] = peak_mib([&] { result = hull::carve(in, the_pitch(), {}); });
  if (result.hull.groups.empty()) return state.SkipWithError("an empty hull");
  state.counters["groups"] = static_cast<double>(result.hull.groups.size());
  state.counters["samples"] = static_cast<double>(result.report.inside_samples);
  for (auto _ : state) benchmark::DoNotOptimize(hull::carve(in, the_pitch(), {}));
}

std::size_t carve_boxes(const std::vector<codec::CameraView>& in) {
  std::vector<cv::Mat> masks;
  const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {7, 7});
  for (const codec::CameraView& view : in) {
    const image::Image<std::uint8_t>& alpha = view.matte->alpha;
    cv::dilate(
        cv::Mat(alpha.height(), alpha.width(), CV_8UC1, const_cast<std::uint8_t*>(alpha.data())),
        masks.emplace_back(), disc);
  }
  std::vector<Eigen::Matrix<float, 3, 4>> projections;
  for (const codec::CameraView& view : in) {
    const geometry::CameraModel& m = view.estimate.model;
    Eigen::Matrix3d k;
    k << m.fx, 0, m.cx, 0, m.fy, m.cy, 0, 0, 1;
    Eigen::Matrix<double, 3, 4> rt;
    rt << view.estimate.cam_from_world.rotation.toRotationMatrix(),
        view.estimate.cam_from_world.translation;
    projections.push_back((k * rt).cast<float>());
  }
  std::size_t inside = 0;
  const auto steps = [](double metres) { return static_cast<int>(std::lround(metres / kVoxel)); };
  for (const Eigen::Vector2d& place : places()) {
    const double turf = the_pitch().turf_z(place.y());
    for (int z = 0; z < steps(2.0); ++z) {
      for (int y = 0; y < steps(1.6); ++y) {
        for (int x = 0; x < steps(1.6); ++x) {
          const Eigen::Vector4f p(static_cast<float>(place.x() - 0.8 + x * kVoxel),
                                  static_cast<float>(place.y() - 0.8 + y * kVoxel),
                                  static_cast<float>(turf + z * kVoxel), 1);
          bool kept = true;
          for (std::size_t c = 0; kept && c < in.size(); ++c) {
            const Eigen::Vector3f q = projections[c] * p;
            const int u = static_cast<int>(q.x() / q.z() + 0.5f);
            const int v = static_cast<int>(q.y() / q.z() + 0.5f);
            if (u < 0 || v < 0 || u >= masks[c].cols || v >= masks[c].rows) continue;
            kept = masks[c].at<std::uint8_t>(v, u) != 0;
          }
          inside += kept;
        }
      }
    }
  }
  return inside;
}

void plain_grid(benchmark::State& state, const std::vector<codec::CameraView>& in) {
  std::size_t inside = 0;
  for (auto _ : state) inside = carve_boxes(in);
  state.counters["samples"] = static_cast<double>(inside);
}

struct Carved {
  hull::Volume volume;
  hull::Components components;
  std::vector<std::uint8_t> keep;
};

const Carved& carved() {
  static const Carved made = [] {
    std::vector<hull::SilhouetteMap> maps;
    const hull::HullOptions options;
    for (const codec::CameraView& view : views(Size::k1080)) {
      maps.emplace_back(view, options.alpha_threshold, options.dilation_px);
    }
    Carved out;
    out.volume = hull::carve_volume(maps, the_pitch(), options);
    out.components = hull::label_components(out.volume, the_pitch());
    out.keep.assign(out.components.list.size(), 1);
    return out;
  }();
  return made;
}

void surfaces(benchmark::State& state) {
  const Cores limit(kMost, 1);
  const Carved& in = carved();
  std::size_t triangles = 0;
  for (const auto& mesh : hull::extract_surfaces(in.volume, in.components, in.keep)) {
    triangles += mesh.triangles.size();
  }
  state.counters["triangles"] = static_cast<double>(triangles);
  for (auto _ : state) {
    benchmark::DoNotOptimize(hull::extract_surfaces(in.volume, in.components, in.keep));
  }
}

#ifdef TOUCHLINE_BENCH_VTK
// The field in the box round each component, with a margin of one sample.
std::vector<VtkGrid> grids() {
  const Carved& in = carved();
  std::vector<VtkGrid> out;
  for (const hull::Component& component : in.components.list) {
    const double voxel = in.volume.voxel_m;
    Eigen::Vector3i low;
    Eigen::Vector3i count;
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = static_cast<int>(std::lround(component.bounds.min()[axis] / voxel)) - 1;
      count[axis] =
          static_cast<int>(std::lround(component.bounds.max()[axis] / voxel)) + 2 - low[axis];
    }
    VtkGrid grid(count.x(), count.y(), count.z(), voxel, -static_cast<float>(voxel));
    for (const hull::Brick& brick : in.volume.bricks) {
      const Eigen::Vector3i first(brick.key.x * hull::kBrick - low.x(),
                                  brick.key.y * hull::kBrick - low.y(),
                                  brick.key.z * hull::kBrick - low.z());
      for (int s = 0; s < hull::kBrickSamples; ++s) {
        const int x = first.x() + s % hull::kBrick;
        const int y = first.y() + s / hull::kBrick % hull::kBrick;
        const int z = first.z() + s / (hull::kBrick * hull::kBrick);
        if (x < 0 || y < 0 || z < 0 || x >= count.x() || y >= count.y() || z >= count.z()) continue;
        grid.set(x, y, z, brick.field[static_cast<std::size_t>(s)]);
      }
    }
    out.push_back(std::move(grid));
  }
  return out;
}

void vtk_surfaces(benchmark::State& state, bool flying_edges) {
  std::vector<VtkGrid> in = grids();
  std::size_t triangles = 0;
  for (auto _ : state) {
    triangles = 0;
    for (VtkGrid& grid : in) triangles += grid.triangles(flying_edges);
  }
  state.counters["triangles"] = static_cast<double>(triangles);
}
#endif

void people(benchmark::State& state, Size size) {
  const hull::HullResult result = hull::carve(views(size), the_pitch(), {});
  track::PeopleTracker tracker(the_pitch());
  std::int64_t instant = 0;
  std::size_t found = 0;
  const auto next = [&] {
    instant += 40'000'000;
    return tracker.update(result.hull, views(size), base::MediaTime{instant}).size();
  };
  for (int i = 0; i < 6; ++i) found = next();
  state.counters["people"] = static_cast<double>(found);
  if (found == 0) return state.SkipWithError("nobody");
  for (auto _ : state) benchmark::DoNotOptimize(next());
}

void add_all() {
  for (const Size size : kSizes) {
    const std::string crowded = name(size) + " 12 cameras 22 people 2 cm";
    add("hull", kOurs, crowded, [=](auto& state) { hull(state, views(size), 1); });
    add("hull", "plain grid in boxes round the people", crowded,
        [=](auto& state) { plain_grid(state, views(size)); });
    add("hull", kOurs, crowded + ", 2 cores", [=](auto& state) {
      hull(state, views(size), 2);
    }).by_wall();
    add("hull", kOurs, name(size) + " recording",
        [=](auto& state) { hull(state, instant(size), 1); });
    add("people", kOurs, crowded, [=](auto& state) { people(state, size); });
  }
  const std::string samples = "12 cameras 22 people 2 cm";
  add("surface", kOurs, samples, surfaces);
#ifdef TOUCHLINE_BENCH_VTK
  add("surface", "VTK flying edges", samples, [](auto& state) { vtk_surfaces(state, true); });
  add("surface", "VTK marching cubes", samples, [](auto& state) { vtk_surfaces(state, false); });
#endif
}

}  // namespace
}  // namespace touchline::bench

int main(int argc, char** argv) {
  touchline::bench::add_all();
  return touchline::bench::run(argc, argv);
}
