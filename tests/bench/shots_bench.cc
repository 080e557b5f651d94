// Hull and picture of one instant of the embedded sample, from true cameras and mattes: what the
// hub needs for a frame at 1280x720. TOUCHLINE_RECORDING names another recording.
#include <benchmark/benchmark.h>
#include <oneapi/tbb/global_control.h>

#include <cstdlib>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "edge/plate/plate_builder.h"
#include "hub/hull/carve.h"
#include "hub/render/renderer.h"
#include "shared/recording/recording.h"
#include "shared/recording/video_reader.h"
#include "tools/score/oracle.h"
#include "tools/score/truth.h"

namespace touchline {
namespace {

struct Scene {
  pitch::PitchModel pitch;
  std::vector<codec::CameraView> views;
  std::map<base::CameraId, image::PlateSnapshot> plates;
  geometry::CameraEstimate virtual_camera;
};

base::Result<Scene> load() {
  const char* named = std::getenv("TOUCHLINE_RECORDING");
  const auto recording = recording::load_recording(named != nullptr ? named : "tests/data/sample");
  if (!recording) return base::fail(recording.error());
  const auto truth = score::Truth::open(*recording);
  if (!truth) return base::fail(truth.error());
  Scene scene;
  auto pitch = pitch::make_pitch(recording->sport, recording->sizes);
  if (!pitch) return base::fail(pitch.error());
  scene.pitch = std::move(*pitch);
  auto oracle = score::Oracle::open(*recording, *truth, {});
  if (!oracle) return base::fail(oracle.error());
  auto views = oracle->next();
  if (!views) return base::fail(views.error());
  if (!*views) return base::fail(base::ErrorKind::kNotFound, "frame 0", "the recording has none");
  scene.views = std::move(**views);
  for (const recording::CameraEntry& entry : recording->cameras) {
    auto reader = recording::VideoReader::open(entry, *recording, 1);
    const auto first = truth->camera(entry.id, 0);
    if (!reader || !first) continue;
    plate::PlateBuilder builder(scene.pitch, geometry::position_in_world(*first),
                                1 / first->model.fx);
    for (std::int64_t k = 0;; ++k) {
      const auto frame = reader->next();
      const auto camera = truth->camera(entry.id, k);
      if (!frame || !*frame || !camera) break;
      builder.add(**frame, *camera);
    }
    scene.plates[entry.id] = *builder.snapshot(true);
  }
  const auto camera = truth->camera(base::CameraId{"virtual01"}, 0);
  if (!camera)
    return base::fail(base::ErrorKind::kNotFound, "virtual01", "the recording has no such camera");
  scene.virtual_camera = *camera;
  return scene;
}

const base::Result<Scene>& scene() {
  static const base::Result<Scene> loaded = load();
  return loaded;
}

void hull(benchmark::State& state) {
  const auto& s = scene();
  if (!s) return state.SkipWithError(base::to_string(s.error()).c_str());
  const oneapi::tbb::global_control cores(oneapi::tbb::global_control::max_allowed_parallelism,
                                          static_cast<std::size_t>(state.range(0)));
  hull::HullOptions options;
  options.voxel_m = static_cast<double>(state.range(1)) / 1000;
  std::size_t groups = 0;
  for (auto _ : state) groups = hull::carve(s->views, s->pitch, options).hull.groups.size();
  state.counters["groups"] = static_cast<double>(groups);
}
BENCHMARK(hull)
    ->ArgNames({"cores", "voxel_mm"})
    ->Args({1, 20})
    ->Args({2, 20})
    ->Args({2, 10})
    ->Args({2, 40})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

void picture(benchmark::State& state) {
  const auto& s = scene();
  if (!s) return state.SkipWithError(base::to_string(s.error()).c_str());
  const oneapi::tbb::global_control cores(oneapi::tbb::global_control::max_allowed_parallelism,
                                          static_cast<std::size_t>(state.range(0)));
  const auto carved = hull::carve(s->views, s->pitch, {});
  const auto renderer = render::Renderer::make(
      s->pitch, s->plates, render::estimate_colour_reference(s->pitch, s->plates));
  if (!renderer) return state.SkipWithError(base::to_string(renderer.error()).c_str());
  double unseen = 0;
  for (auto _ : state) {
    unseen = renderer->render(s->views, carved.hull, s->virtual_camera, render::Mode::kHull)
                 .report.unseen_share;
  }
  state.counters["unseen"] = unseen;
}
BENCHMARK(picture)->ArgName("cores")->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace touchline
