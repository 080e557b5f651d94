// From a keyed frame to what is sent. Peers: OpenCV's contours, which follow pixels and keep no
// sub-pixel boundary, and its ORB over the whole frame.
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "edge/encode/assemble.h"
#include "edge/encode/features.h"
#include "edge/encode/silhouettes.h"
#include "edge/encode/tile_places.h"
#include "shared/codec/view_codec.h"
#include "tests/bench/bench.h"
#include "tests/bench/input.h"

namespace touchline::bench {
namespace {

const codec::CameraView& view(Size size) { return instant(size).front(); }
const image::Frame& frame(Size size) {
  return *camera_frames(recording::Role::kMatch, size).frames.front();
}

cv::Mat mask(Size size) {
  const image::Image<std::uint8_t>& alpha = view(size).matte->alpha;
  cv::Mat out;
  cv::compare(
      cv::Mat(alpha.height(), alpha.width(), CV_8UC1, const_cast<std::uint8_t*>(alpha.data())), 127,
      out, cv::CMP_GT);
  return out;
}

void assemble(benchmark::State& state, Size size) {
  const codec::CameraView& in = view(size);
  const auto once = [&] {
    return encode::assemble(frame(size), in.estimate, *in.matte, the_pitch(), {});
  };
  state.counters["peak_mib"] = peak_mib([&] { benchmark::DoNotOptimize(once()); });
  for (auto _ : state) benchmark::DoNotOptimize(once());
}

void whole(benchmark::State& state, Size size) {
  const codec::CameraView& in = view(size);
  std::size_t bytes = 0;
  for (auto _ : state) {
    const auto encoded =
        codec::encode(encode::assemble(frame(size), in.estimate, *in.matte, the_pitch(), {}));
    if (!encoded) return state.SkipWithError(base::to_string(encoded.error()).c_str());
    bytes = 0;
    for (const codec::EncodedPart& part : encoded->parts) bytes += part.bytes.size();
  }
  state.counters["bytes"] = static_cast<double>(bytes);
}

void silhouettes(benchmark::State& state, Size size) {
  const image::Matte& matte = *view(size).matte;
  for (auto _ : state) benchmark::DoNotOptimize(encode::trace_silhouettes(matte, 0.3f));
}

void contours(benchmark::State& state, Size size) {
  const cv::Mat in = mask(size);
  for (auto _ : state) {
    std::vector<std::vector<cv::Point>> found;
    cv::findContours(in, found, cv::RETR_CCOMP, cv::CHAIN_APPROX_NONE);
    for (std::vector<cv::Point>& ring : found) cv::approxPolyDP(ring, ring, 0.3, true);
    benchmark::DoNotOptimize(found.data());
  }
}

void features(benchmark::State& state, Size size) {
  const image::Matte& matte = *view(size).matte;
  const auto boxes = encode::foreground_boxes(matte);
  for (auto _ : state) {
    benchmark::DoNotOptimize(encode::find_features(frame(size), matte, boxes, 120));
  }
}

void orb(benchmark::State& state, Size size) {
  const image::Image<std::uint16_t>& luma = frame(size).planes[0];
  cv::Mat grey;
  cv::Mat(luma.height(), luma.width(), CV_16UC1, const_cast<std::uint16_t*>(luma.data()))
      .convertTo(grey, CV_8U, 0.25);
  const cv::Mat where = mask(size);
  const auto detector = cv::ORB::create(120);
  for (auto _ : state) {
    std::vector<cv::KeyPoint> points;
    cv::Mat descriptors;
    detector->detectAndCompute(grey, where, points, descriptors);
    benchmark::DoNotOptimize(descriptors.data);
  }
}

void add_all() {
  for (const Size size : kSizes) {
    add("assemble", kOurs, name(size), [=](auto& state) { assemble(state, size); });
    add("assemble and encode", kOurs, name(size), [=](auto& state) { whole(state, size); });
    add("silhouettes", kOurs, name(size), [=](auto& state) { silhouettes(state, size); });
    add("silhouettes", "OpenCV findContours, approxPolyDP", name(size),
        [=](auto& state) { contours(state, size); });
    add("features", kOurs, name(size), [=](auto& state) { features(state, size); });
    add("features", "OpenCV ORB, default", name(size), [=](auto& state) { orb(state, size); });
  }
}

}  // namespace
}  // namespace touchline::bench

int main(int argc, char** argv) {
  touchline::bench::add_all();
  return touchline::bench::run(argc, argv);
}
