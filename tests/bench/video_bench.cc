// Reading video: CPU milliseconds a frame, the first frame and what opening costs left out. Peer:
// the ffmpeg program with one thread on the same file, as `ffmpeg -benchmark` counts, which decodes
// and throws away; ours also brings every frame into planes of its own.
#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "shared/recording/video_reader.h"
#include "tests/bench/bench.h"
#include "tests/bench/input.h"
#include "tests/support/folders.h"
#include "tests/support/video_fixture.h"

namespace touchline::bench {
namespace {

// The head's video, or a lossless H.264 of the same frames doubled.
recording::CameraEntry source(Size size) {
  recording::CameraEntry entry = first_camera(recording::Role::kMatch);
  if (size == Size::k1080) return entry;
  static const support::TempFolder folder;
  static const std::filesystem::path path = [] {
    const auto& frames = camera_frames(recording::Role::kMatch, Size::k2160).raw;
    support::VideoSpec spec;
    spec.codec = "libx264";
    spec.width = 3840;
    spec.height = 2160;
    spec.frames = static_cast<int>(frames.size());
    const auto file = folder / "large.mkv";
    must(support::write_video(file, spec, [&](int frame, int plane, int x, int y) {
      return frames[static_cast<std::size_t>(frame)]->planes[static_cast<std::size_t>(plane)](x, y);
    }));
    return file;
  }();
  entry.video = path;
  entry.width = 3840;
  entry.height = 2160;
  return entry;
}

void read_video(benchmark::State& state, Size size) {
  const recording::CameraEntry entry = source(size);
  std::size_t frames = 0;
  for (auto _ : state) {
    auto reader = must(recording::VideoReader::open(entry, the_recording(), 1));
    benchmark::DoNotOptimize(must(reader.next()));
    const double start = cpu_seconds();
    frames = 1;
    while (auto frame = must(reader.next())) {
      benchmark::DoNotOptimize(frame);
      ++frames;
    }
    if (frames < 2) return state.SkipWithError("one frame alone cannot be timed");
    state.SetIterationTime((cpu_seconds() - start) / static_cast<double>(frames - 1));
  }
  state.counters["frames"] = static_cast<double>(frames);
}

struct Spent {
  double seconds = -1;
  int frames = 0;
};

// User and system seconds, and frames, by the program's own account.
Spent ffmpeg(const std::string& file, const std::string& limit) {
  const std::string command = fmt::format(
      "ffmpeg -hide_banner -nostdin -threads 1 -benchmark -i '{}' {} -map 0:v -f null - 2>&1", file,
      limit);
  Spent out;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return out;
  std::array<char, 4096> line{};
  double user = 0;
  double system = 0;
  while (std::fgets(line.data(), static_cast<int>(line.size()), pipe) != nullptr) {
    const std::string text(line.data());
    const std::size_t bench = text.find("bench: utime=");
    if (bench != std::string::npos &&
        std::sscanf(text.c_str() + bench, "bench: utime=%lfs stime=%lfs", &user, &system) == 2) {
      out.seconds = user + system;
    }
    const std::size_t at = text.rfind("frame=");
    if (at != std::string::npos) out.frames = std::atoi(text.c_str() + at + 6);
  }
  if (pclose(pipe) != 0) out.seconds = -1;
  return out;
}

void run_ffmpeg(benchmark::State& state, Size size) {
  const std::string file = source(size).video.string();
  for (auto _ : state) {
    const Spent one = ffmpeg(file, "-frames:v 1");
    const Spent all = ffmpeg(file, "");
    if (one.seconds < 0 || all.seconds < 0 || all.frames < 2) {
      return state.SkipWithError("ffmpeg did not run");
    }
    state.SetIterationTime(std::max(0.0, all.seconds - one.seconds) / (all.frames - 1));
  }
}

void add_all() {
  for (const Size size : kSizes) {
    add("read video", kOurs, name(size), [=](auto& state) { read_video(state, size); })
        .by_hand()
        .once();
    add("read video", "ffmpeg -benchmark", name(size),
        [=](auto& state) { run_ffmpeg(state, size); })
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
