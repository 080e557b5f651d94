#include "edge/plate_keeper.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <utility>

#include "shared/base/bounds.h"

namespace touchline::edge {
namespace {

constexpr std::uintmax_t kLargestFile = std::uintmax_t{1} << 31;

// Whole or not at all: a file that is there stays as it was until the new one is complete.
base::Status write_plate(const std::filesystem::path& path, const codec::SavedPlate& saved) {
  const auto bytes = codec::encode_plate_file(saved);
  if (!bytes) return base::fail(bytes.error());
  std::filesystem::path part = path;
  part += ".part";
  const auto failed = [&](const std::string& what) {
    std::error_code ignored;
    std::filesystem::remove(part, ignored);
    return base::fail(base::ErrorKind::kIo, path.string(), "the plate " + what,
                      "choose a folder that can be written and has room");
  };
  {
    std::ofstream out(part, std::ios::binary | std::ios::trunc);
    out.write(reinterpret_cast<const char*>(bytes->data()),
              static_cast<std::streamsize>(bytes->size()));
    out.close();
    if (!out) return failed("cannot be written");
  }
  std::error_code error;
  std::filesystem::rename(part, path, error);
  if (error) return failed("cannot be put in place: " + error.message());
  return {};
}

base::Result<std::vector<std::uint8_t>> bytes_of(const std::filesystem::path& path) {
  const auto wrong = [&](const char* what) {
    return base::fail(base::ErrorKind::kIo, path.string(), what);
  };
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) return wrong("cannot be read");
  if (size > kLargestFile) return wrong("is too large for a plate");
  std::vector<std::uint8_t> bytes(size);
  std::ifstream in(path, std::ios::binary);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (!in) return wrong("cannot be read");
  return bytes;
}

// Why a plate is of no use here; empty where it is.
std::string misfit(const codec::SavedPlate& saved, const base::CameraId& camera,
                   const PlatePlace& place, double most_scale) {
  if (saved.camera != camera) return fmt::format("it is of camera {}", saved.camera.value);
  if (saved.width != place.width || saved.height != place.height) {
    return fmt::format("it is of pictures of {}x{}, not {}x{}", saved.width, saved.height,
                       place.width, place.height);
  }
  if (saved.plate.colour != place.colour) return "its colours are coded another way";
  const double scale = saved.plate.radians_per_px * place.focal_px;
  if (!(scale <= most_scale && scale >= 1 / most_scale))
    return fmt::format("its pixels are {:.2f} times as large as the camera's", scale);
  return {};
}

}  // namespace

base::Status PlateKeepOptions::validate() const {
  for (const auto& status : {base::in_bounds("save_frames", save_frames, 25, 1000000),
                             base::in_bounds("most_moved_m", most_moved_m, 0, 10),
                             base::in_bounds("most_scale", most_scale, 1, 10)})
    if (!status) return status;
  return {};
}

PlateKeeper::PlateKeeper(base::CameraId camera, PlateKeepOptions options,
                         runtime::Executor& executor)
    : camera_(std::move(camera)), options_(std::move(options)), executor_(executor) {}

PlateKeeper::~PlateKeeper() = default;

std::optional<codec::SavedPlate> PlateKeeper::read(const PlatePlace& place,
                                                   const plate::PlateOptions& options) {
  std::error_code error;
  if (options_.load.empty() || !std::filesystem::exists(options_.load, error)) return std::nullopt;
  const auto bytes = bytes_of(options_.load);
  auto decoded = bytes ? codec::decode_plate_file(
                             *bytes, {.max_tiles = static_cast<std::size_t>(options.max_tiles)})
                       : base::fail(bytes.error());
  if (!decoded) {
    notes_.push_back(fmt::format("saved plate not used: {}: {}", options_.load.string(),
                                 base::to_string(decoded.error())));
    return std::nullopt;
  }
  for (const std::string& what : decoded->dropped)
    notes_.push_back(fmt::format("saved plate: {}: {}", options_.load.string(), what));
  const std::string why = misfit(decoded->saved, camera_, place, options_.most_scale);
  if (!why.empty()) {
    notes_.push_back(fmt::format("saved plate not used: {}: {}", options_.load.string(), why));
    return std::nullopt;
  }
  return std::move(decoded->saved);
}

std::unique_ptr<plate::PlateBuilder> PlateKeeper::start(const pitch::PitchModel& pitch,
                                                        const PlatePlace& place,
                                                        plate::PlateOptions options) {
  place_ = place;
  frames_before_ = 0;
  judged_ = true;
  const auto made = [&](double radians_per_px) {
    return std::make_unique<plate::PlateBuilder>(pitch, place.centre_in_world, radians_per_px,
                                                 options);
  };
  const auto saved = std::exchange(asked_, true) ? std::nullopt : read(place, options);
  if (saved) {
    auto plate = made(saved->plate.radians_per_px);
    const base::Status status = plate->resume(saved->plate, options_.most_moved_m);
    if (status) {
      frames_before_ = saved->frames;
      judged_ = false;
      notes_.push_back(fmt::format("plate goes on from {}: {} tiles, {} frames",
                                   options_.load.string(), saved->plate.tiles.size(),
                                   saved->frames));
      return plate;
    }
    notes_.push_back(
        fmt::format("saved plate not used: {}: {}", options_.load.string(), status.error().what));
  }
  return made(1 / place.focal_px);
}

codec::SavedPlate PlateKeeper::to_save(plate::PlateBuilder& plate) const {
  codec::SavedPlate saved;
  saved.camera = camera_;
  saved.width = place_.width;
  saved.height = place_.height;
  saved.frames = frames_before_ + static_cast<std::uint64_t>(plate.frames());
  saved.plate = *plate.snapshot(true);
  return saved;
}

void PlateKeeper::after_frame(plate::PlateBuilder& plate) {
  if (!judged_) {
    if (const auto apart = plate.resumed_apart()) {
      judged_ = true;
      notes_.push_back(fmt::format("saved plate: {:.1f} % of it looks another way now{}",
                                   100 * *apart, *apart > 0.5 ? ": it is forgotten" : ""));
    }
  }
  if (options_.save.empty()) return;
  if (writing_.valid() && writing_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    const base::Status status = writing_.get();
    if (!status && !write_failed_) notes_.push_back(base::to_string(status.error()));
    write_failed_ = !status;
  }
  if (++frames_since_save_ < options_.save_frames || writing_.valid()) return;
  frames_since_save_ = 0;
  auto done = std::make_shared<std::promise<base::Status>>();
  auto write = [path = options_.save, saved = to_save(plate), done] {
    done->set_value(write_plate(path, saved));
  };
  if (executor_.post(std::move(write))) writing_ = done->get_future();
}

void PlateKeeper::wait() {
  if (!writing_.valid()) return;
  executor_.drain();
  writing_ = {};
}

base::Status PlateKeeper::save(plate::PlateBuilder* plate) {
  if (options_.save.empty()) return {};
  wait();
  if (plate == nullptr || plate->frames() == 0) return {};
  return write_plate(options_.save, to_save(*plate));
}

std::vector<std::string> PlateKeeper::take_notes() { return std::exchange(notes_, {}); }

}  // namespace touchline::edge
