// Undoing the camera's detail setting. Peers: OpenCV's filter2D with the very kernel that ours
// comes to, and a 5x5 unsharp mask, which is as wide as the boost but does not undo it.
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "edge/compensate/compensator.h"
#include "edge/compensate/detail_estimator.h"
#include "tests/bench/bench.h"
#include "tests/bench/input.h"

namespace touchline::bench {
namespace {

constexpr int kReach = 6;  // of the compensator's kernel, pixels

state::DetailModel detail() {
  state::DetailModel model = camera_frames(recording::Role::kMatch, Size::k1080).detail;
  // A recording without detail would time a copy.
  if (!compensate::Compensator(model).active()) {
    model.horizontal = {0.3, 0};
    model.vertical = {0.3, 0};
  }
  return model;
}

const image::Frame& frame(Size size) {
  return *camera_frames(recording::Role::kMatch, size).raw.front();
}

cv::Mat as_mat(const image::Image<std::uint16_t>& luma) {
  return {luma.height(), luma.width(), CV_16UC1, const_cast<std::uint16_t*>(luma.data())};
}

// The compensator's answer to a single brighter pixel.
cv::Mat kernel() {
  constexpr int kSize = 8 * kReach + 1;
  image::Image<std::uint16_t> impulse(kSize, kSize, 300);
  impulse(kSize / 2, kSize / 2) = 1000;
  const auto answer = compensate::Compensator(detail()).apply(impulse.view());
  cv::Mat out(2 * kReach + 1, 2 * kReach + 1, CV_32F);
  for (int y = -kReach; y <= kReach; ++y) {
    for (int x = -kReach; x <= kReach; ++x) {
      out.at<float>(kReach + y, kReach + x) =
          static_cast<float>(answer(kSize / 2 + x, kSize / 2 + y) - 300) / 700;
    }
  }
  return out / cv::sum(out)[0];
}

void ours(benchmark::State& state, Size size) {
  const compensate::Compensator undo(detail());
  const image::Frame& in = frame(size);
  state.counters["peak_mib"] = peak_mib([&] { benchmark::DoNotOptimize(undo.apply(in.luma())); });
  for (auto _ : state) benchmark::DoNotOptimize(undo.apply(in.luma()));
}

void same_kernel(benchmark::State& state, Size size) {
  const cv::Mat filter = kernel();
  const cv::Mat in = as_mat(frame(size).planes[0]);
  cv::Mat out;
  cv::filter2D(in, out, -1, filter, {-1, -1}, 0, cv::BORDER_REPLICATE);
  const auto answer = compensate::Compensator(detail()).apply(frame(size).luma());
  const double apart =
      cv::norm(out, as_mat(answer), cv::NORM_L1) / static_cast<double>(out.total());
  state.counters["differs_codes"] = apart;
  if (apart > 2) return state.SkipWithError("the kernel is not the compensator's");
  for (auto _ : state) {
    cv::filter2D(in, out, -1, filter, {-1, -1}, 0, cv::BORDER_REPLICATE);
  }
}

void unsharp(benchmark::State& state, Size size) {
  const cv::Mat in = as_mat(frame(size).planes[0]);
  cv::Mat blurred;
  cv::Mat out;
  for (auto _ : state) {
    cv::GaussianBlur(in, blurred, {5, 5}, 1, 1, cv::BORDER_REPLICATE);
    cv::addWeighted(in, 0.6, blurred, 0.4, 0, out);
  }
}

void estimate(benchmark::State& state, Size size) {
  const image::Frame& in = frame(size);
  state.counters["peak_mib"] = peak_mib([&] {
    compensate::DetailEstimator estimator;
    estimator.add(in.luma());
    benchmark::DoNotOptimize(estimator.estimate());
  });
  for (auto _ : state) {
    compensate::DetailEstimator estimator;
    estimator.add(in.luma());
    benchmark::DoNotOptimize(estimator.estimate());
  }
}

void add_all() {
  for (const Size size : kSizes) {
    add("compensate", kOurs, name(size), [=](auto& state) { ours(state, size); });
    add("compensate", "OpenCV filter2D, same kernel", name(size),
        [=](auto& state) { same_kernel(state, size); });
    add("compensate", "OpenCV 5x5 unsharp", name(size), [=](auto& state) { unsharp(state, size); });
    add("estimate detail", kOurs, name(size), [=](auto& state) { estimate(state, size); });
  }
}

}  // namespace
}  // namespace touchline::bench

int main(int argc, char** argv) {
  touchline::bench::add_all();
  return touchline::bench::run(argc, argv);
}
