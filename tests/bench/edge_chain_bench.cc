// The whole edge chain on one core, by stage: milliseconds a 1080p frame of the embedded sample.
// TOUCHLINE_RECORDING names another recording.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "edge/capture/recording_source.h"
#include "edge/edge_config.h"
#include "edge/frame_chain.h"
#include "shared/recording/recording.h"
#include "shared/recording/video_reader.h"

namespace touchline {
namespace {

void edge_chain(benchmark::State& state, const std::string& camera) {
  const char* named = std::getenv("TOUCHLINE_RECORDING");
  const auto recording = recording::load_recording(named != nullptr ? named : "tests/data/sample");
  if (!recording) return state.SkipWithError(base::to_string(recording.error()).c_str());
  const base::CameraId id{camera};
  const auto setup = edge::chain_setup(*recording, id);
  if (!setup) return state.SkipWithError(base::to_string(setup.error()).c_str());
  const edge::SurveyStills stills = edge::load_stills(*recording->find(id));
  auto reader = recording::VideoReader::open(*recording->find(id), *recording, 1);
  if (!reader) return state.SkipWithError(base::to_string(reader.error()).c_str());
  std::vector<image::FramePtr> frames;
  while (auto frame = reader->next()) {
    if (!*frame) break;
    frames.push_back(std::make_shared<const image::Frame>(std::move(**frame)));
  }

  std::vector<edge::StageTime> total;
  std::uint64_t lost = 0, bytes = 0;
  for (auto _ : state) {
    auto chain = edge::FrameChain::make(*setup, {}, stills.frames);
    if (!chain) return state.SkipWithError(base::to_string(chain.error()).c_str());
    const auto count = [&](const edge::ChainOutput& out) {
      for (const codec::EncodedView& view : out.views) {
        for (const codec::EncodedPart& part : view.parts) bytes += part.bytes.size();
      }
    };
    for (const image::FramePtr& frame : frames) count(chain->push(frame));
    count(chain->finish());
    const edge::ChainReport report = chain->report();
    lost += report.frames_lost;
    if (total.empty()) {
      total = report.stages;
    } else {
      for (std::size_t i = 0; i < total.size(); ++i) {
        total[i].seconds += report.stages[i].seconds;
        total[i].frames += report.stages[i].frames;
      }
    }
  }
  const double all = static_cast<double>(frames.size()) * static_cast<double>(state.iterations());
  double chain_ms = 0;
  for (const edge::StageTime& stage : total) {
    // The survey is done once a match, not once a frame.
    if (stage.stage == "survey") {
      state.counters["survey_s"] = stage.seconds / static_cast<double>(state.iterations());
      continue;
    }
    state.counters[stage.stage + "_ms"] = 1e3 * stage.seconds / all;
    chain_ms += 1e3 * stage.seconds / all;
  }
  state.counters["chain_ms"] = chain_ms;
  state.counters["lost"] = static_cast<double>(lost) / static_cast<double>(state.iterations());
  state.counters["kB_frame"] = static_cast<double>(bytes) / 1e3 / all;
}

BENCHMARK_CAPTURE(edge_chain, match_m1, "m1")->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(edge_chain, match_m3, "m3")->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(edge_chain, fixed_f1, "f1")->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
}  // namespace touchline
