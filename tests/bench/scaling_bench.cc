// How the hub's work grows: with cameras (22 people), with people (12 cameras), with the voxel's
// size (12 cameras, 22 people), at 1080p. The crowd's tiles are a pattern of checks and noise.
#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>

#include "edge/encode/assemble.h"
#include "hub/decode/decode_set.h"
#include "hub/hull/carve.h"
#include "hub/render/renderer.h"
#include "hub/track/people_tracker.h"
#include "shared/codec/view_codec.h"
#include "tests/bench/bench.h"
#include "tests/bench/input.h"
#include "tests/support/capsule_scene.h"

namespace touchline::bench {
namespace {

using Cores = oneapi::tbb::global_control;

// What a hub gets of one instant, and what the stages make of it.
struct Instant {
  scene::FrameSet set;
  std::vector<codec::CameraView> views;
  scene::Hull hull;
};

// A picture of checks and noise, the same for every camera.
const image::Frame& video() {
  static const image::Frame made = [] {
    image::Frame out;
    out.format = image::PixelFormat::kYuv422p10;
    out.planes[0] = image::Image<std::uint16_t>(1920, 1080);
    out.planes[1] = out.planes[2] = image::Image<std::uint16_t>(960, 1080, 512);
    std::uint32_t random = 1;
    for (int y = 0; y < 1080; ++y) {
      for (int x = 0; x < 1920; ++x) {
        random = random * 1664525u + 1013904223u;
        const bool light = ((x / 6) + (y / 9)) % 2 != 0;
        out.planes[0](x, y) = static_cast<std::uint16_t>((light ? 600 : 250) + (random >> 28));
      }
    }
    return out;
  }();
  return made;
}

Instant make(int cameras, int people) {
  Instant out;
  for (codec::CameraView& silhouette : crowd(cameras, people, Size::k1080)) {
    codec::CameraView view = encode::assemble(video(), silhouette.estimate,
                                              std::move(*silhouette.matte), the_pitch(), {});
    view.id.camera = silhouette.id.camera;
    out.set.entries.push_back({view.id.camera, must(codec::encode(view))});
  }
  out.views = must(decode::decode_set(out.set)).views;
  out.hull = hull::carve(out.views, the_pitch(), {}).hull;
  return out;
}

const Instant& crowded(int cameras, int people) {
  static std::map<std::pair<int, int>, Instant> cache;
  const auto key = std::pair(cameras, people);
  const auto found = cache.find(key);
  if (found != cache.end()) return found->second;
  return cache.emplace(key, make(cameras, people)).first->second;
}

const render::Renderer& renderer() {
  static const render::Renderer made = must(render::Renderer::make(
      the_pitch(), plates(), render::estimate_colour_reference(the_pitch(), plates())));
  return made;
}

geometry::CameraEstimate viewer() {
  return scaled(support::looking_at({-30, -45, 9}, {0, 0, 0.8}, 2200, 1920, 1080),
                smoke() ? 0.125 : 1);
}

void add_stages(const std::string& point, int cameras, int people) {
  const auto one_core = [](auto work) {
    return [=](benchmark::State& state) {
      const Cores limit(Cores::max_allowed_parallelism, 1);
      work(state);
    };
  };
  add("scale.decode", kOurs, point, one_core([=](benchmark::State& state) {
        const Instant& in = crowded(cameras, people);
        for (auto _ : state) benchmark::DoNotOptimize(decode::decode_set(in.set));
      }));
  add("scale.hull", kOurs, point, one_core([=](benchmark::State& state) {
        const Instant& in = crowded(cameras, people);
        state.counters["groups"] = static_cast<double>(in.hull.groups.size());
        state.counters["peak_mib"] =
            peak_mib([&] { benchmark::DoNotOptimize(hull::carve(in.views, the_pitch(), {})); });
        for (auto _ : state) benchmark::DoNotOptimize(hull::carve(in.views, the_pitch(), {}));
      }));
  add("scale.people", kOurs, point, one_core([=](benchmark::State& state) {
        const Instant& in = crowded(cameras, people);
        track::PeopleTracker tracker(the_pitch());
        std::int64_t time = 0;
        for (auto _ : state) {
          time += 40'000'000;
          benchmark::DoNotOptimize(tracker.update(in.hull, in.views, base::MediaTime{time}));
        }
      }));
  add("scale.render", kOurs, point, one_core([=](benchmark::State& state) {
        const Instant& in = crowded(cameras, people);
        const render::Renderer& ready = renderer();
        const geometry::CameraEstimate camera = viewer();
        for (auto _ : state) {
          benchmark::DoNotOptimize(ready.render(in.views, in.hull, camera, render::Mode::kHull));
        }
      }));
}

void add_all() {
  if (smoke()) return add_stages("cameras:2", 2, 3);
  for (const int cameras : {2, 4, 8, 12, 16, 25}) {
    add_stages(fmt::format("cameras:{}", cameras), cameras, 22);
  }
  for (const int people : {1, 5, 11, 22, 30}) {
    add_stages(fmt::format("people:{}", people), 12, people);
  }
  for (const int millimetres : {10, 20, 40}) {
    add("scale.hull", kOurs, fmt::format("voxel_mm:{}", millimetres), [=](benchmark::State& state) {
      const Cores limit(Cores::max_allowed_parallelism, 1);
      const Instant& in = crowded(12, 22);
      hull::HullOptions options;
      options.voxel_m = millimetres / 1000.0;
      state.counters["peak_mib"] =
          peak_mib([&] { benchmark::DoNotOptimize(hull::carve(in.views, the_pitch(), options)); });
      for (auto _ : state) {
        benchmark::DoNotOptimize(hull::carve(in.views, the_pitch(), options));
      }
    });
  }
}

}  // namespace
}  // namespace touchline::bench

int main(int argc, char** argv) {
  touchline::bench::add_all();
  return touchline::bench::run(argc, argv);
}
