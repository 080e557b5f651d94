// The hub's work for one picture of the recording: decode, hull, people, picture, and all of them
// in a row. Peer of the picture: Embree's primary rays in packets of eight over the same hull and
// turf, its hierarchy built each time as ours is: what any ray caster spends before it shades a
// pixel.
#include <embree3/rtcore.h>
#include <oneapi/tbb/global_control.h>

#include <cmath>
#include <limits>

#include "hub/decode/decode_set.h"
#include "hub/hull/carve.h"
#include "hub/render/renderer.h"
#include "hub/track/people_tracker.h"
#include "shared/codec/view_codec.h"
#include "tests/bench/bench.h"
#include "tests/bench/input.h"

namespace touchline::bench {
namespace {

using Cores = oneapi::tbb::global_control;
constexpr auto kMost = Cores::max_allowed_parallelism;

const scene::FrameSet& frame_set(Size size) {
  static std::map<Size, scene::FrameSet> cache;
  scene::FrameSet& set = cache[size];
  if (set.entries.empty()) {
    for (const codec::CameraView& view : instant(size)) {
      set.entries.push_back({view.id.camera, must(codec::encode(view))});
    }
  }
  return set;
}

const std::vector<codec::CameraView>& decoded(Size size) {
  static std::map<Size, std::vector<codec::CameraView>> cache;
  auto& views = cache[size];
  if (views.empty()) views = must(decode::decode_set(frame_set(size))).views;
  return views;
}

const scene::Hull& the_hull(Size size) {
  static std::map<Size, scene::Hull> cache;
  scene::Hull& hull = cache[size];
  if (hull.groups.empty()) hull = hull::carve(decoded(size), the_pitch(), {}).hull;
  return hull;
}

const render::Renderer& renderer() {
  static const render::Renderer made = must(render::Renderer::make(
      the_pitch(), plates(), render::estimate_colour_reference(the_pitch(), plates())));
  return made;
}

void decode(benchmark::State& state, Size size, std::size_t cores) {
  const Cores limit(kMost, cores);
  state.counters["cameras"] = static_cast<double>(frame_set(size).entries.size());
  state.counters["peak_mib"] =
      peak_mib([&] { benchmark::DoNotOptimize(decode::decode_set(frame_set(size))); });
  for (auto _ : state) benchmark::DoNotOptimize(decode::decode_set(frame_set(size)));
}

void picture(benchmark::State& state, Size size, std::size_t cores) {
  const Cores limit(kMost, cores);
  const geometry::CameraEstimate camera = virtual_camera(size);
  const auto& views = decoded(size);
  const scene::Hull& hull = the_hull(size);
  const render::Renderer& ready = renderer();
  const auto once = [&] { return ready.render(views, hull, camera, render::Mode::kHull); };
  render::RenderResult result;
  state.counters["peak_mib"] = peak_mib([&] { result = once(); });
  state.counters["unseen"] = result.report.unseen_share;
  state.counters["foreground"] = result.report.foreground_share;
  for (auto _ : state) benchmark::DoNotOptimize(once());
}

class Primary {
 public:
  explicit Primary(const scene::Hull& hull) : device_(rtcNewDevice("threads=1,isa=avx2")) {
    scene_ = rtcNewScene(device_);
    for (const scene::HullGroup& group : hull.groups) add(group.surface);
    geometry::Mesh turf;
    turf.vertices = {{-200, -200, 0}, {200, -200, 0}, {200, 200, 0}, {-200, 200, 0}};
    turf.triangles = {{0, 1, 2}, {0, 2, 3}};
    add(turf);
    rtcCommitScene(scene_);
  }
  ~Primary() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  Primary(const Primary&) = delete;
  Primary& operator=(const Primary&) = delete;

  std::size_t hits(const geometry::CameraEstimate& camera) const {
    const Eigen::Vector3f eye = geometry::position_in_world(camera).cast<float>();
    const Eigen::Matrix3f back =
        camera.cam_from_world.rotation.conjugate().toRotationMatrix().cast<float>();
    const auto fx = static_cast<float>(1 / camera.model.fx);
    const auto fy = static_cast<float>(1 / camera.model.fy);
    const auto cx = static_cast<float>(camera.model.cx);
    const auto cy = static_cast<float>(camera.model.cy);
    std::size_t count = 0;
    alignas(32) int valid[8];
    std::fill(std::begin(valid), std::end(valid), -1);
    for (int y = 0; y + 1 < camera.model.height; y += 2) {
      for (int x = 0; x + 3 < camera.model.width; x += 4) {
        RTCRayHit8 rays;
        for (int i = 0; i < 8; ++i) {
          const Eigen::Vector3f ray =
              back * Eigen::Vector3f((static_cast<float>(x + i % 4) - cx) * fx,
                                     (static_cast<float>(y + i / 4) - cy) * fy, 1);
          rays.ray.org_x[i] = eye.x();
          rays.ray.org_y[i] = eye.y();
          rays.ray.org_z[i] = eye.z();
          rays.ray.dir_x[i] = ray.x();
          rays.ray.dir_y[i] = ray.y();
          rays.ray.dir_z[i] = ray.z();
          rays.ray.tnear[i] = 0;
          rays.ray.tfar[i] = std::numeric_limits<float>::infinity();
          rays.ray.time[i] = 0;
          rays.ray.mask[i] = 0xffffffffu;
          rays.ray.flags[i] = 0;
          rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
          rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
        }
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        rtcIntersect8(valid, scene_, &context, &rays);
        for (unsigned id : rays.hit.geomID) count += id != RTC_INVALID_GEOMETRY_ID;
      }
    }
    return count;
  }

 private:
  void add(const geometry::Mesh& mesh) {
    const RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, mesh.vertices.size()));
    for (const Eigen::Vector3f& v : mesh.vertices) {
      for (int axis = 0; axis < 3; ++axis) *vertices++ = v[axis];
    }
    auto* triangles = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, mesh.triangles.size()));
    for (const auto& t : mesh.triangles) {
      for (const std::uint32_t v : t) *triangles++ = v;
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
  }

  RTCDevice device_;
  RTCScene scene_ = nullptr;
};

void primary_rays(benchmark::State& state, Size size) {
  const Cores limit(kMost, 1);
  const geometry::CameraEstimate camera = virtual_camera(size);
  std::size_t hits = 0;
  for (auto _ : state) hits = Primary(the_hull(size)).hits(camera);
  state.counters["hits"] = static_cast<double>(hits);
}

void chain(benchmark::State& state, Size size, std::size_t cores) {
  const Cores limit(kMost, cores);
  const geometry::CameraEstimate camera = virtual_camera(size);
  const render::Renderer& ready = renderer();
  track::PeopleTracker tracker(the_pitch());
  std::int64_t time = 0;
  const auto once = [&] {
    time += 40'000'000;
    const auto set = decode::decode_set(frame_set(size));
    const auto carved = hull::carve(set->views, the_pitch(), {});
    benchmark::DoNotOptimize(tracker.update(carved.hull, set->views, base::MediaTime{time}));
    return ready.render(set->views, carved.hull, camera, render::Mode::kHull);
  };
  state.counters["peak_mib"] = peak_mib([&] { benchmark::DoNotOptimize(once()); });
  for (auto _ : state) benchmark::DoNotOptimize(once());
}

void prepare(benchmark::State& state) {
  const Cores limit(kMost, 1);
  for (auto _ : state) {
    benchmark::DoNotOptimize(render::Renderer::make(
        the_pitch(), plates(), render::estimate_colour_reference(the_pitch(), plates())));
  }
}

void add_all() {
  for (const Size size : kSizes) {
    for (const std::size_t cores : {1u, 2u}) {
      const std::string where = name(size) + (cores == 2 ? ", 2 cores" : "");
      const auto timed = [=](const Added& added) {
        if (cores == 2) added.by_wall();
      };
      timed(add("decode", kOurs, where, [=](auto& state) { decode(state, size, cores); }));
      timed(add("render", kOurs, where, [=](auto& state) { picture(state, size, cores); }));
      timed(add("shot chain", kOurs, where, [=](auto& state) { chain(state, size, cores); }));
    }
    add("render", "Embree primary rays only", name(size),
        [=](auto& state) { primary_rays(state, size); });
  }
  add("prepare renderer", kOurs, "1080p plates", prepare).once();
}

}  // namespace
}  // namespace touchline::bench

int main(int argc, char** argv) {
  touchline::bench::add_all();
  return touchline::bench::run(argc, argv);
}
