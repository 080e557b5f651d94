#include "hub/session/session_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <system_error>
#include <tuple>
#include <utility>

#include "hub/session/index_internal.h"
#include "hub/session/record_internal.h"
#include "shared/codec/plate_codec.h"
#include "shared/codec/view_codec.h"

namespace touchline::session {
namespace {

using base::ErrorKind;
using base::MediaTime;
namespace fs = std::filesystem;

constexpr std::size_t kMaxFaults = 1000;
// Media times farther than this from the session's start are taken for damage: 30 years.
constexpr std::int64_t kMaxDistance_ns = 946'080'000'000'000'000;

// The first media time of the first camera that has any.
MediaTime first_time(const Index& index) {
  for (std::size_t camera = 0; camera < index.info.cameras.size(); ++camera) {
    const MediaTime* first = nullptr;
    for (const ViewRow& view : index.views) {
      if (view.camera == camera && (first == nullptr || view.time < *first)) first = &view.time;
    }
    if (first != nullptr) return *first;
  }
  return {};
}

// Whole periods from `start` to the nearest instant.
std::int64_t nearest_instant(MediaTime start, base::FrameRate rate, MediaTime time) {
  const auto distance = static_cast<double>(time.ns - start.ns);
  auto k = static_cast<std::int64_t>(std::llround(distance * 1e-9 * rate.hz()));
  const auto off = [&](std::int64_t n) {
    return std::abs(base::frame_time(start, rate, n).ns - time.ns);
  };
  while (off(k - 1) < off(k)) --k;
  while (off(k + 1) < off(k)) ++k;
  return k;
}

OpenReport report_of(const fs::path& folder, const Index& index) {
  OpenReport report;
  report.finished = index.finished;
  report.views = index.views.size();
  report.plate_tiles = index.plates.size();
  report.events = index.events.size();
  std::map<std::uint32_t, std::uint64_t> ends;
  const auto note = [&](const RecordPlace& place) {
    std::uint64_t& end = ends[place.segment];
    end = std::max(end, place.end());
  };
  for (const ViewRow& view : index.views) note(view.place);
  for (const PlateRow& plate : index.plates) note(plate.place);
  std::map<std::string, std::uint64_t> end_by_name;
  std::error_code error;
  for (const auto& [segment, end] : ends) {
    const std::string name = segment_name(segment);
    end_by_name[name] = end;
    if (!fs::exists(folder / name, error)) report.missing_segments.push_back(name);
  }
  for (fs::directory_iterator it(folder, error), last; !error && it != last; it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (name.rfind("segment-", 0) != 0) continue;
    std::error_code size_error;
    const std::uint64_t size = fs::file_size(it->path(), size_error);
    const auto found = end_by_name.find(name);
    const std::uint64_t end = found == end_by_name.end() ? kSegmentHeaderBytes : found->second;
    if (!size_error && size > end) report.unindexed_bytes += size - end;
  }
  return report;
}

}  // namespace

class SessionReader::Impl {
 public:
  Impl(const fs::path& folder, Index index, const codec::DecodeLimits& limits)
      : folder_(folder),
        limits_(limits),
        index_(std::move(index)),
        report_(report_of(folder, index_)) {
    const SessionInfo& info = index_.info;
    start_ = info.start ? *info.start : first_time(index_);
    std::int64_t tolerance = info.tolerance_ns;
    if (tolerance == 0) tolerance = static_cast<std::int64_t>(info.rate.period_s() * 0.5e9) + 1;
    arrange(tolerance);
  }

  base::Result<scene::FrameSet> frame_set(std::size_t i) const {
    if (i >= times_.size()) {
      return base::fail(ErrorKind::kArgument, folder_.string(),
                        fmt::format("instant {} of {}", i, times_.size()));
    }
    scene::FrameSet set;
    set.instant = times_[i];
    for (std::size_t camera = 0; camera < index_.info.cameras.size(); ++camera) {
      set.entries.push_back({index_.info.cameras[camera].id, entry(i, camera)});
    }
    return set;
  }

  base::Result<std::map<base::CameraId, image::PlateSnapshot>> plates() const {
    std::map<base::CameraId, image::PlateSnapshot> plates;
    for (std::size_t camera = 0; camera < index_.info.cameras.size(); ++camera) {
      image::PlateSnapshot plate = plate_of(camera);
      if (!plate.tiles.empty()) plates[index_.info.cameras[camera].id] = std::move(plate);
    }
    return plates;
  }

  base::Result<VerifyReport> verify(const VerifyOptions& options) const {
    VerifyReport report;
    report.open = report_;
    const auto fault = [&](const RecordPlace& place, const std::string& of,
                           const base::Error& error) {
      ++report.fault_count;
      if (report.faults.size() == kMaxFaults) return;
      report.faults.push_back(
          {fmt::format("{} at {}: {}", segment_name(place.segment), place.offset, of),
           to_string(error)});
    };
    for (const ViewRow& row : index_.views) {
      ++report.payloads;
      report.bytes += row.place.length;
      const std::string of =
          fmt::format("{} epoch {} sequence {}", name(row.camera), row.epoch, row.sequence);
      const auto view = read(row);
      if (!view) {
        fault(row.place, of, view.error());
      } else if (options.decode) {
        if (const auto decoded = codec::decode(*view, options.limits); !decoded) {
          fault(row.place, of, decoded.error());
        }
      }
    }
    for (const PlateRow& row : index_.plates) {
      ++report.payloads;
      report.bytes += row.place.length;
      const std::string of = fmt::format("{} plate tile ({}, {}) version {}", name(row.camera),
                                         row.key.column, row.key.row, row.version);
      const auto tile = read(row);
      if (!tile) {
        fault(row.place, of, tile.error());
      } else if (options.decode) {
        const auto decoded =
            codec::decode_plate_tile(tile->bytes, tile->format_version, options.limits);
        if (!decoded) fault(row.place, of, decoded.error());
      }
    }
    return report;
  }

  const SessionInfo& info() const { return index_.info; }
  const OpenReport& report() const { return report_; }
  const std::vector<MediaTime>& instants() const { return times_; }
  std::int64_t frame_number(std::size_t i) const { return i < numbers_.size() ? numbers_[i] : -1; }
  const std::vector<Event>& events() const { return index_.events; }

 private:
  // How far from an instant a view of each camera may lie: no farther than half of what usually
  // lies between that camera's frames, so that the frames between the instants of a faster camera
  // belong to none.
  std::vector<std::int64_t> reach_of_cameras(std::int64_t tolerance) const {
    std::vector<std::vector<std::int64_t>> times(index_.info.cameras.size());
    for (const ViewRow& view : index_.views) {
      if (std::abs(view.time.ns / 4) <= kMaxDistance_ns) times[view.camera].push_back(view.time.ns);
    }
    std::vector<std::int64_t> reach;
    for (std::vector<std::int64_t>& of : times) {
      std::sort(of.begin(), of.end());
      of.erase(std::unique(of.begin(), of.end()), of.end());
      std::vector<std::int64_t> gaps;
      for (std::size_t i = 1; i < of.size(); ++i) gaps.push_back(of[i] - of[i - 1]);
      if (gaps.empty()) {
        reach.push_back(tolerance);
        continue;
      }
      const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
      std::nth_element(gaps.begin(), middle, gaps.end());
      reach.push_back(std::min(tolerance, *middle / 2 + 1));
    }
    return reach;
  }

  // Gives every view to its instant; of two of one camera the nearer, then the later epoch.
  void arrange(std::int64_t tolerance) {
    struct Claim {
      std::int64_t number = 0;
      std::size_t camera = 0;
      std::int64_t distance = 0;
      std::size_t view = 0;
    };
    std::vector<Claim> claims;
    const std::vector<std::int64_t> reach = reach_of_cameras(tolerance);
    for (std::size_t i = 0; i < index_.views.size(); ++i) {
      const ViewRow& view = index_.views[i];
      if (view.time.ns > kMaxDistance_ns * 4 || view.time.ns < -kMaxDistance_ns * 4 ||
          std::abs(view.time.ns - start_.ns) > kMaxDistance_ns) {
        continue;
      }
      const std::int64_t number = nearest_instant(start_, index_.info.rate, view.time);
      const std::int64_t distance =
          std::abs(base::frame_time(start_, index_.info.rate, number).ns - view.time.ns);
      if (distance <= reach[view.camera]) claims.push_back({number, view.camera, distance, i});
    }
    const auto rank = [&](const Claim& claim) {
      return std::tuple(claim.number, claim.camera, claim.distance,
                        -static_cast<std::int64_t>(index_.views[claim.view].epoch), claim.view);
    };
    std::sort(claims.begin(), claims.end(),
              [&](const Claim& a, const Claim& b) { return rank(a) < rank(b); });
    const std::size_t cameras = index_.info.cameras.size();
    spans_.resize(cameras);
    for (const Claim& claim : claims) {
      if (numbers_.empty() || numbers_.back() != claim.number) {
        numbers_.push_back(claim.number);
        times_.push_back(base::frame_time(start_, index_.info.rate, claim.number));
        chosen_.resize(numbers_.size() * cameras, nullptr);
      }
      const ViewRow*& chosen = chosen_[(numbers_.size() - 1) * cameras + claim.camera];
      if (chosen == nullptr) chosen = &index_.views[claim.view];
      auto& [first, last] = spans_[claim.camera];
      if (!first) first = claim.number;
      last = claim.number;
    }
  }

  std::variant<codec::EncodedView, scene::Absent> entry(std::size_t i, std::size_t camera) const {
    using scene::AbsentReason;
    const ViewRow* const row = chosen_[i * index_.info.cameras.size() + camera];
    if (row != nullptr) {
      auto view = read(*row);
      if (view) return std::move(*view);
      return scene::Absent{AbsentReason::kUndecodable};
    }
    const auto& [first, last] = spans_[camera];
    if (!first || numbers_[i] < *first) return scene::Absent{AbsentReason::kNotYet};
    if (numbers_[i] > *last) return scene::Absent{AbsentReason::kEnded};
    return scene::Absent{AbsentReason::kLostInTransit};
  }

  const std::string& name(std::size_t camera) const { return index_.info.cameras[camera].id.value; }

  base::Result<codec::EncodedView> read(const ViewRow& row) const {
    const auto bytes = read_record(folder_, row.place, RecordKind::kView);
    if (!bytes) return base::fail(bytes.error());
    auto view = unpack_view(*bytes);
    if (view && (view->id.camera.value != name(row.camera) || view->id.epoch != row.epoch ||
                 view->id.sequence != row.sequence || view->stamp.media_time != row.time)) {
      return base::fail(ErrorKind::kFormat, "view record", "another view than the index names");
    }
    return view;
  }

  base::Result<codec::EncodedPlateTile> read(const PlateRow& row) const {
    const auto bytes = read_record(folder_, row.place, RecordKind::kPlateTile);
    if (!bytes) return base::fail(bytes.error());
    auto tile = unpack_plate_tile(*bytes);
    if (tile && (tile->camera.value != name(row.camera) || tile->key != row.key ||
                 tile->epoch != row.epoch || tile->plate_version != row.version)) {
      return base::fail(ErrorKind::kFormat, "plate tile record",
                        "another tile than the index names");
    }
    return tile;
  }

  // From the newest version of the newest run back, so that the newest tile says which centre and
  // scale hold.
  image::PlateSnapshot plate_of(std::size_t camera) const {
    std::vector<const PlateRow*> rows;
    for (const PlateRow& row : index_.plates) {
      if (row.camera == camera) rows.push_back(&row);
    }
    std::stable_sort(rows.begin(), rows.end(), [](const PlateRow* a, const PlateRow* b) {
      return std::pair(a->epoch, a->version) > std::pair(b->epoch, b->version);
    });
    image::PlateSnapshot plate;
    for (const PlateRow* row : rows) {
      if (plate.tiles.count(row->key) != 0) continue;
      const auto tile = read(*row);
      if (!tile) continue;
      // Tiles of another centre or scale, and damaged ones, are left out.
      static_cast<void>(codec::add_to_plate(*tile, limits_, plate));
    }
    return plate;
  }

  fs::path folder_;
  codec::DecodeLimits limits_;
  Index index_;
  OpenReport report_;
  MediaTime start_;
  std::vector<MediaTime> times_;
  std::vector<std::int64_t> numbers_;
  std::vector<const ViewRow*> chosen_;  // instant by instant, one a camera
  std::vector<std::pair<std::optional<std::int64_t>, std::optional<std::int64_t>>> spans_;
};

SessionReader::SessionReader(std::unique_ptr<const Impl> impl) : impl_(std::move(impl)) {}
SessionReader::SessionReader(SessionReader&&) noexcept = default;
SessionReader& SessionReader::operator=(SessionReader&&) noexcept = default;
SessionReader::~SessionReader() = default;

base::Result<SessionReader> SessionReader::open(const fs::path& folder,
                                                const codec::DecodeLimits& limits) {
  auto index = read_index(folder);
  if (!index) return base::fail(index.error());
  return SessionReader(std::make_unique<const Impl>(folder, std::move(*index), limits));
}

const SessionInfo& SessionReader::info() const { return impl_->info(); }
const OpenReport& SessionReader::report() const { return impl_->report(); }
const std::vector<MediaTime>& SessionReader::instants() const { return impl_->instants(); }
std::int64_t SessionReader::frame_number(std::size_t index) const {
  return impl_->frame_number(index);
}
base::Result<scene::FrameSet> SessionReader::frame_set(std::size_t index) const {
  return impl_->frame_set(index);
}
base::Result<std::map<base::CameraId, image::PlateSnapshot>> SessionReader::plates() const {
  return impl_->plates();
}
base::Result<std::vector<Event>> SessionReader::events() const { return impl_->events(); }
base::Result<VerifyReport> SessionReader::verify(const VerifyOptions& options) const {
  return impl_->verify(options);
}

}  // namespace touchline::session
