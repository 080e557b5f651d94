#include "edge/publish/open_track_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string_view>

#include "shared/geometry/mount.h"

namespace touchline::publish {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr std::int64_t kNanoseconds = 1'000'000'000;
constexpr std::size_t kHeaderBytes = 16;
constexpr std::uint8_t kJsonEncoding = 0x01;

// FNV-1a with an own start, then the finaliser of splitmix64 so that all bits depend on all.
std::uint64_t hash(std::string_view text, std::uint64_t start) {
  std::uint64_t h = 14695981039346656037ull ^ start;
  for (const char c : text) {
    h ^= static_cast<std::uint8_t>(c);
    h *= 1099511628211ull;
  }
  h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ull;
  h = (h ^ (h >> 27)) * 0x94d049bb133111ebull;
  return h ^ (h >> 31);
}

// A UUID of the application's own making (RFC 9562, version 8) from a name.
std::string uuid_urn(std::string_view name) {
  const std::uint64_t high = (hash(name, 1) & 0xFFFFFFFFFFFF0FFFull) | 0x8000ull;
  const std::uint64_t low = (hash(name, 2) & 0x3FFFFFFFFFFFFFFFull) | 0x8000000000000000ull;
  return fmt::format("urn:uuid:{:08x}-{:04x}-{:04x}-{:04x}-{:012x}", high >> 32,
                     (high >> 16) & 0xFFFFu, high & 0xFFFFu, low >> 48, low & 0xFFFFFFFFFFFFull);
}

Json rate_json(base::FrameRate rate) { return {{"num", rate.num}, {"denom", rate.den}}; }

Json timing(const SampleContext& context) {
  Json out;
  const std::int64_t ns = context.stamp.media_time.ns;
  const bool stamped = ns >= 0;
  // UDP has no time of its own, so the sample carries it where there is one.
  out["mode"] = stamped ? "internal" : "external";
  out["sampleRate"] = rate_json(context.rate);
  if (stamped) {
    out["sampleTimestamp"] = {{"seconds", ns / kNanoseconds}, {"nanoseconds", ns % kNanoseconds}};
  }
  out["sequenceNumber"] = context.frame.sequence & 0xFFFFFFFFull;
  const base::ClockDomain domain = context.stamp.domain;
  if (domain == base::ClockDomain::kPtp || domain == base::ClockDomain::kNtp) {
    out["synchronization"] = {{"locked", true},
                              {"source", domain == base::ClockDomain::kPtp ? "ptp" : "ntp"},
                              {"present", true}};
  }
  if (context.stamp.timecode) {
    const base::Timecode& code = *context.stamp.timecode;
    out["timecode"] = {{"hours", code.hours},
                       {"minutes", code.minutes},
                       {"seconds", code.seconds},
                       {"frames", code.frames},
                       {"frameRate", rate_json(context.rate)}};
  }
  return out;
}

Json lens(const geometry::CameraModel& model, double mm_per_px) {
  const double focal = model.fx * mm_per_px;
  Json out;
  out["distortion"] = {
      {{"model", "Brown-Conrady U-D"},
       {"radial",
        {model.k1 / (focal * focal), 0.0, model.k2 / std::pow(focal, 4), 0.0, 0.0, 0.0}}}};
  out["entrancePupilOffset"] = 0.0;
  out["pinholeFocalLength"] = focal;
  out["projectionOffset"] = {{"x", (model.cx - (model.width - 1) / 2.0) * mm_per_px},
                             {"y", (model.cy - (model.height - 1) / 2.0) * mm_per_px}};
  return out;
}

Json transforms(const geometry::CameraEstimate& estimate) {
  const Eigen::Vector3d angles = geometry::pan_tilt_roll(estimate.cam_from_world.rotation);
  const Eigen::Vector3d position = geometry::position_in_world(estimate);
  Json camera;
  camera["translation"] = {{"x", position.x()}, {"y", position.y()}, {"z", position.z()}};
  camera["rotation"] = {{"pan", -angles.x() * kDegrees},
                        {"tilt", angles.y() * kDegrees},
                        {"roll", angles.z() * kDegrees}};
  camera["id"] = "Camera";
  return Json::array({camera});
}

Json fixed_data(const geometry::CameraModel& model, const SampleContext& context,
                double mm_per_px) {
  Json camera;
  camera["captureFrameRate"] = rate_json(context.rate);
  camera["activeSensorPhysicalDimensions"] = {{"height", model.height * mm_per_px},
                                              {"width", model.width * mm_per_px}};
  camera["activeSensorResolution"] = {{"height", model.height}, {"width", model.width}};
  camera["label"] = context.frame.camera.value;
  return {{"camera", camera}, {"tracker", {{"make", "Touchline"}, {"model", "touchline-edge"}}}};
}

// JSON has no word for what is not a number: such an estimate says nothing.
bool says_where(const geometry::CameraEstimate& estimate) {
  const geometry::CameraModel& model = estimate.model;
  double sum = 0;  // of magnitudes: finite when all of them are
  for (const double value : {model.fx, model.cx, model.cy, model.k1, model.k2})
    sum += std::abs(value);
  sum += estimate.cam_from_world.rotation.coeffs().cwiseAbs().sum() +
         estimate.cam_from_world.translation.cwiseAbs().sum() + std::abs(estimate.rms_px);
  return !estimate.lost() && model.fx > 0 && model.width > 0 && std::isfinite(sum);
}

void put(std::vector<std::uint8_t>& bytes, std::uint64_t value, int count) {
  for (int i = count - 1; i >= 0; --i)
    bytes.push_back(static_cast<std::uint8_t>((value >> (8 * i)) & 0xFFu));
}

}  // namespace

std::string open_track_io_sample(const geometry::CameraEstimate& estimate,
                                 const SampleContext& context, const OpenTrackIoOptions& options) {
  const geometry::CameraModel& model = estimate.model;
  const double mm_per_px = options.sensor_width_mm / std::max(model.width, 1);
  const std::string source =
      fmt::format("touchline/{}/{}", options.system, context.frame.camera.value);
  const bool known = says_where(estimate);
  Json out;
  if (context.with_static && model.width > 0) out["static"] = fixed_data(model, context, mm_per_px);
  out["tracker"] = {
      {"status",
       known ? fmt::format("{}, rms {:.2f} px", geometry::name(estimate.evidence), estimate.rms_px)
             : std::string("lost")}};
  out["timing"] = timing(context);
  if (known) out["lens"] = lens(model, mm_per_px);
  out["protocol"] = {{"name", "OpenTrackIO"}, {"version", {1, 0, 1}}};
  out["sampleId"] =
      uuid_urn(fmt::format("{}/{}/{}", source, context.frame.epoch, context.frame.sequence));
  out["sourceId"] = uuid_urn(source);
  out["sourceNumber"] = options.source_number;
  if (known) out["transforms"] = transforms(estimate);
  return out.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::vector<std::vector<std::uint8_t>> open_track_io_packets(const std::string& sample,
                                                             std::uint16_t sequence,
                                                             ChecksumOrder order,
                                                             std::size_t most_payload) {
  constexpr std::size_t kMost = 32767;
  const std::size_t step = std::clamp<std::size_t>(most_payload, 1, kMost);
  std::vector<std::vector<std::uint8_t>> packets;
  for (std::size_t at = 0; at < sample.size(); at += step) {
    const std::string_view part = std::string_view(sample).substr(at, step);
    const bool last = at + part.size() == sample.size();
    std::vector<std::uint8_t>& packet = packets.emplace_back();
    packet.reserve(kHeaderBytes + part.size());
    packet.insert(packet.end(), {'O', 'T', 'r', 'k', 0, kJsonEncoding});
    put(packet, sequence, 2);
    put(packet, at, 4);
    put(packet, (last ? 0x8000u : 0u) | part.size(), 2);
    std::uint8_t first_sum = 0, second_sum = 0;
    const auto add = [&](std::uint8_t byte) {
      first_sum = static_cast<std::uint8_t>(first_sum + byte);
      second_sum = static_cast<std::uint8_t>(second_sum + first_sum);
    };
    for (const std::uint8_t byte : packet) add(byte);
    for (const char c : part) add(static_cast<std::uint8_t>(c));
    const bool second_first = order == ChecksumOrder::kSecondSumFirst;
    packet.push_back(second_first ? second_sum : first_sum);
    packet.push_back(second_first ? first_sum : second_sum);
    packet.insert(packet.end(), part.begin(), part.end());
  }
  return packets;
}

}  // namespace touchline::publish
