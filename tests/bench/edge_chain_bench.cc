// The whole edge chain on one core: CPU milliseconds a frame once the first frames, from which
// detail and plate are learnt, are through. Each stage, and learning and survey, which happen once
// a match, are counters.
#include <algorithm>
#include <memory>

#include "edge/edge_config.h"
#include "edge/frame_chain.h"
#include "tests/bench/bench.h"
#include "tests/bench/input.h"

namespace touchline::bench {
namespace {

using recording::Role;

void chain(benchmark::State& state, Size size, Role role) {
  const recording::CameraEntry& entry = first_camera(role);
  const edge::ChainSetup setup = must(edge::chain_setup(the_recording(), entry.id));
  edge::SurveyStills stills = edge::load_stills(entry);
  std::vector<image::FramePtr> frames = camera_frames(role, Size::k1080).raw;
  if (size == Size::k2160) {
    for (image::Frame& still : stills.frames) still = doubled(still);
    frames = camera_frames(role, size).raw;
  }
  // The first frames are held while detail and plate are learnt; the others are timed.
  const std::size_t held = std::max<std::size_t>(1, std::min<std::size_t>(4, frames.size() / 2));
  edge::ChainOptions options;
  options.hold_back_s = (static_cast<double>(held) - 0.5) * setup.rate.period_s();
  if (frames.size() < 2) return state.SkipWithError("two frames or more are needed");
  for (auto _ : state) {
    std::vector<image::Frame> copy = stills.frames;
    std::size_t bytes = 0;
    double learnt = 0;
    double spent = 0;
    edge::ChainReport before;
    edge::ChainReport report;
    const double peak = peak_mib([&] {
      auto made = must(edge::FrameChain::make(setup, options, std::move(copy)));
      double start = cpu_seconds();
      for (std::size_t i = 0; i < held; ++i) made.push(frames[i]);
      learnt = cpu_seconds() - start;
      before = made.report();
      start = cpu_seconds();
      for (std::size_t i = held; i < frames.size(); ++i) {
        for (const codec::EncodedView& view : made.push(frames[i]).views) {
          for (const codec::EncodedPart& part : view.parts) bytes += part.bytes.size();
        }
      }
      spent = cpu_seconds() - start;
      report = made.report();
    });
    const auto all = static_cast<double>(frames.size() - held);
    for (std::size_t i = 0; i < report.stages.size(); ++i) {
      const edge::StageTime& stage = report.stages[i];
      if (stage.stage == "survey") {
        state.counters["survey_s"] = stage.seconds;
      } else {
        state.counters[stage.stage + "_ms"] =
            1e3 * (stage.seconds - before.stages[i].seconds) / all;
      }
    }
    state.counters["learn_s"] = learnt;
    state.counters["lost"] = static_cast<double>(report.frames_lost);
    state.counters["bytes"] = static_cast<double>(bytes) / all;
    state.counters["peak_mib"] = peak;
    state.SetIterationTime(spent / all);
    if (role == Role::kMatch && size == Size::k1080 && report.frames_lost == report.frames_in) {
      return state.SkipWithError("every frame is lost");
    }
  }
}

void add_all() {
  for (const Size size : kSizes) {
    if (!smoke()) {  // a head's survey takes seconds
      add("edge chain", kOurs, name(size) + " head",
          [=](auto& state) { chain(state, size, Role::kMatch); })
          .by_hand()
          .once();
    }
    add("edge chain", kOurs, name(size) + " fixed",
        [=](auto& state) { chain(state, size, Role::kFixed); })
        .by_hand()
        .once();
  }
}

}  // namespace
}  // namespace touchline::bench

int main(int argc, char** argv) {
  touchline::bench::add_all();
  return touchline::bench::run(argc, argv);
}
