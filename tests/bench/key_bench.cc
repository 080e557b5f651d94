// Plate and key against OpenCV's background subtractors on the same frames, with what each finds:
// F is the harmonic mean of precision and recall of foreground pixels against the true mattes, over
// the second half of the frames. The subtractors get R'G'B' for nothing, and their shadows count as
// background.
#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/background_segm.hpp>

#include "edge/key/key.h"
#include "edge/plate/plate_builder.h"
#include "shared/image/colour.h"
#include "tests/bench/bench.h"
#include "tests/bench/input.h"

namespace touchline::bench {
namespace {

using recording::Role;

std::string label(Size size, Role role) {
  return name(size) + (role == Role::kMatch ? " head" : " fixed");
}

class FScore {
 public:
  void add(const image::Image<std::uint8_t>& truth, const std::function<bool(std::size_t)>& found) {
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const bool is = truth.data()[i] >= 128;
      const bool says = found(i);
      both_ += is && says;
      true_ += is;
      found_ += says;
    }
  }
  double value() const { return true_ + found_ > 0 ? 2 * both_ / (true_ + found_) : 0; }

 private:
  double both_ = 0;
  double true_ = 0;
  double found_ = 0;
};

void key_frames(benchmark::State& state, Size size, Role role) {
  const CameraFrames& camera = camera_frames(role, size);
  const image::PlateSnapshot& learnt = plate(role, size);
  FScore score;
  state.counters["peak_mib"] = peak_mib([&] {
    benchmark::DoNotOptimize(key::key(*camera.frames[0], camera.truth[0], learnt, the_pitch()));
  });
  for (std::size_t i = camera.frames.size() / 2; i < camera.frames.size(); ++i) {
    const auto result = key::key(*camera.frames[i], camera.truth[i], learnt, the_pitch());
    const std::uint8_t* alpha = result.matte.alpha.data();
    score.add(camera.mattes[i], [&](std::size_t k) { return alpha[k] >= 128; });
  }
  state.counters["F"] = score.value();
  // As a unit keys: what was prepared of the plate is kept from frame to frame.
  const auto kept = std::make_shared<const image::PlateSnapshot>(learnt);
  key::Keyer keyer;
  std::size_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        keyer.key(*camera.frames[next], camera.truth[next], kept, the_pitch()));
    next = (next + 1) % camera.frames.size();
  }
}

cv::Ptr<cv::BackgroundSubtractor> make(bool knn) {
  if (knn) return cv::createBackgroundSubtractorKNN();
  return cv::createBackgroundSubtractorMOG2();
}

void subtract(benchmark::State& state, Size size, Role role, bool knn) {
  const CameraFrames& camera = camera_frames(role, size);
  const std::size_t kept = std::min<std::size_t>(camera.frames.size(), 10);
  std::vector<image::Image<image::Rgb8>> pictures;  // the last of them
  const auto as_mat = [](image::Image<image::Rgb8>& rgb) {
    return cv::Mat(rgb.height(), rgb.width(), CV_8UC3, rgb.data());
  };
  const auto subtractor = make(knn);
  FScore score;
  cv::Mat mask;
  for (std::size_t i = 0; i < camera.frames.size(); ++i) {
    auto rgb = image::to_rgb(*camera.frames[i]);
    if (i == 0) {
      state.counters["peak_mib"] = peak_mib([&] { subtractor->apply(as_mat(rgb), mask); });
    } else {
      subtractor->apply(as_mat(rgb), mask);
    }
    if (2 * i >= camera.frames.size()) {
      score.add(camera.mattes[i], [&](std::size_t k) { return mask.data[k] == 255; });
    }
    if (i + kept >= camera.frames.size()) pictures.push_back(std::move(rgb));
  }
  state.counters["F"] = score.value();
  std::size_t next = 0;
  for (auto _ : state) {
    subtractor->apply(as_mat(pictures[next]), mask);
    next = (next + 1) % pictures.size();
  }
}

void learn(benchmark::State& state, Size size, Role role) {
  const CameraFrames& camera = camera_frames(role, size);
  plate::PlateBuilder builder(the_pitch(), geometry::position_in_world(camera.truth[0]),
                              1 / camera.truth[0].model.fx);
  state.counters["peak_mib"] = peak_mib([&] {
    for (std::size_t i = 0; i < camera.frames.size(); ++i) {
      builder.add(*camera.frames[i], camera.truth[i]);
    }
  });
  std::size_t next = 0;
  for (auto _ : state) {
    builder.add(*camera.frames[next], camera.truth[next]);
    next = (next + 1) % camera.frames.size();
  }
}

void add_all() {
  for (const Size size : kSizes) {
    for (const Role role : {Role::kMatch, Role::kFixed}) {
      const std::string where = label(size, role);
      add("key", kOurs, where, [=](auto& state) { key_frames(state, size, role); });
      add("key", "OpenCV MOG2", where, [=](auto& state) { subtract(state, size, role, false); });
      add("key", "OpenCV KNN", where, [=](auto& state) { subtract(state, size, role, true); });
      add("plate", kOurs, where, [=](auto& state) { learn(state, size, role); });
    }
  }
}

}  // namespace
}  // namespace touchline::bench

int main(int argc, char** argv) {
  touchline::bench::add_all();
  return touchline::bench::run(argc, argv);
}
