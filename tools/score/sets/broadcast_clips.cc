#include "tools/score/sets/broadcast_clips.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "edge/frame_chain.h"
#include "shared/codec/view_codec.h"
#include "shared/geometry/mount.h"
#include "shared/recording/video_reader.h"
#include "tools/score/sets/clip_notes.h"
#include "tools/score/sets/overlay.h"

namespace touchline::score {
namespace {

namespace fs = std::filesystem;
using geometry::CameraEstimate;

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr std::size_t kPictures = 4;  // a clip
constexpr base::FrameRate kRate{30, 1};

double quantile_of(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1,
                         static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

// What came out for one noted frame.
struct Seen {
  const NotedFrame* noted = nullptr;
  codec::CameraView view;
};

class Clip {
 public:
  Clip(fs::path video, ClipNotes notes, const SetOptions& options)
      : video_(std::move(video)), notes_(std::move(notes)), options_(options) {}

  base::Result<SetRow> run(SetReport& report) {
    if (auto status = play(report); !status) return base::fail(status.error());
    SetRow row{video_.stem().string(), {}};
    add_calibration(row);
    add_places(row, report);
    add_key(row);
    return row;
  }

 private:
  base::Status play(SetReport& report) {
    recording::Recording recording;
    recording.rate = kRate;
    recording::CameraEntry camera;
    camera.id.value = "m1";
    camera.video = video_;
    camera.width = notes_.width;
    camera.height = notes_.height;
    camera.rate = kRate;
    auto reader = recording::VideoReader::open(camera, recording, 1);
    if (!reader) return base::fail(reader.error());
    edge::ChainSetup setup;
    setup.camera = camera.id;
    setup.rate = kRate;
    auto chain = edge::FrameChain::make(setup, {}, {});
    if (!chain) return base::fail(chain.error());
    std::int64_t number = 0;
    for (;;) {
      auto frame = reader->next();
      if (!frame) return base::fail(frame.error());
      if (!*frame) break;
      auto shared = std::make_shared<const image::Frame>(std::move(**frame));
      if (is_drawn(number)) drawn_[number] = shared;
      ++number;
      if (auto status = take(chain->push(std::move(shared)), report); !status) return status;
    }
    return take(chain->finish(), report);
  }

  bool is_drawn(std::int64_t number) const {
    if (options_.pictures.empty() || notes_.frames.count(number) == 0) return false;
    const auto at =
        static_cast<std::size_t>(std::distance(notes_.frames.begin(), notes_.frames.find(number)));
    const std::size_t step = std::max<std::size_t>(1, notes_.frames.size() / kPictures);
    return at % step == 0;
  }

  base::Status take(edge::ChainOutput output, SetReport& report) {
    for (const std::string& note : output.notes)
      report.notes.push_back(video_.stem().string() + ": " + note);
    for (const codec::EncodedView& encoded : output.views) {
      cameras_.push_back(encoded.estimate);
      const auto number = static_cast<std::int64_t>(cameras_.size()) - 1;
      const auto noted = notes_.frames.find(number);
      if (noted == notes_.frames.end()) continue;
      auto view = codec::decode(encoded);
      if (!view) return base::fail(view.error());
      view->tiles.reset();
      view->partial.reset();
      measure(noted->second, *view);
      if (const auto frame = drawn_.find(number); frame != drawn_.end()) {
        if (auto status = draw(number, *frame->second, noted->second, *view); !status)
          return status;
        drawn_.erase(frame);
      }
    }
    return {};
  }

  void measure(const NotedFrame& noted, const codec::CameraView& view) {
    boxes_ += noted.people.size();
    if (view.estimate.lost()) return;
    for (const Segment& segment : noted.across)
      if (const auto distance = across_distance(view.estimate, pitch_, segment))
        across_.push_back(*distance);
    for (const EdgePoint& point : turf_edges(view.estimate, pitch_, noted)) {
      // Captions are cut out of the outline as well: only what lies about the lines or beyond is an
      // edge of the turf.
      const double beyond = std::abs(point.on_turf[1 - point.axis]) -
                            0.5 * (point.axis == 0 ? pitch_.width_m : pitch_.length_m);
      if (beyond < -4 || beyond > 40) continue;
      // Hoardings of the left and of the right end are two lines.
      const std::size_t kind =
          point.axis == 0 ? (point.on_turf.y() > 0 ? 0U : 1U) : (point.on_turf.x() < 0 ? 2U : 3U);
      edges_[kind].push_back({view.estimate, point});
    }
    if (!view.matte) return;
    boxes_solved_ += noted.people.size();
    const auto matte = view.matte->alpha.view();
    for (const NotedBox& box : noted.people) held_ += is_held(matte, box) ? 1U : 0U;
    if (const auto share = foreground_on_turf(matte, noted)) on_turf_.push_back(*share);
  }

  void add_calibration(SetRow& row) const {
    const std::size_t all = cameras_.size();
    std::size_t solved = 0, longest = 0, lost_in_a_row = 0;
    for (const CameraEstimate& camera : cameras_) {
      if (!camera.lost()) ++solved;
      lost_in_a_row = camera.lost() ? lost_in_a_row + 1 : 0;
      longest = std::max(longest, lost_in_a_row);
    }
    row.cells.push_back(
        {"solved",
         100.0 * static_cast<double>(solved) / static_cast<double>(std::max<std::size_t>(all, 1)),
         "%", all});
    row.cells.push_back({"longest lost", static_cast<double>(longest), "", all});
    // Second difference of pan, degrees.
    std::vector<double> jerks;
    for (std::size_t i = 2; i < all; ++i) {
      std::array<double, 3> pan{};
      bool whole = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const CameraEstimate& camera = cameras_[i - 2 + k];
        whole = whole && !camera.lost();
        if (whole) pan[k] = geometry::pan_tilt_roll(camera.cam_from_world.rotation).x();
      }
      if (whole)
        jerks.push_back(
            std::abs(std::remainder(pan[2] - 2 * pan[1] + pan[0], 2 * std::numbers::pi)) *
            kDegrees);
    }
    row.cells.push_back({"pan'' median", quantile_of(jerks, 0.5), "deg", jerks.size()});
    row.cells.push_back({"pan'' 95th", quantile_of(jerks, 0.95), "deg", jerks.size()});
  }

  void add_places(SetRow& row, SetReport& report) const {
    row.cells.push_back({"across median", quantile_of(across_, 0.5), "px", across_.size()});
    row.cells.push_back({"across 95th", quantile_of(across_, 0.95), "px", across_.size()});
    std::vector<double> distances;
    std::string places;
    for (std::size_t kind = 0; kind < edges_.size(); ++kind) {
      std::vector<double> values;
      for (const auto& [camera, point] : edges_[kind])
        values.push_back(point.on_turf[1 - point.axis]);
      if (values.size() < 5) continue;
      const double place = quantile_of(values, 0.5);
      for (const auto& [camera, point] : edges_[kind])
        if (const auto distance = edge_distance(camera, pitch_, point, place))
          distances.push_back(*distance);
      const double beyond = std::abs(place) - 0.5 * (kind < 2 ? pitch_.width_m : pitch_.length_m);
      constexpr std::array<const char*, 4> kNames{"far side", "near side", "left end", "right end"};
      places += fmt::format("{}{} {:.1f} m", places.empty() ? "" : ", ", kNames[kind], beyond);
    }
    row.cells.push_back({"outline median", quantile_of(distances, 0.5), "px", distances.size()});
    row.cells.push_back({"outline 95th", quantile_of(distances, 0.95), "px", distances.size()});
    if (!places.empty())
      report.notes.push_back(video_.stem().string() + ": hoardings beyond the lines: " + places);
  }

  void add_key(SetRow& row) const {
    const auto share = [](std::size_t part, std::size_t whole) {
      return whole > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(whole)
                       : std::nan("");
    };
    row.cells.push_back({"people held", share(held_, boxes_), "%", boxes_});
    row.cells.push_back({"where solved", share(held_, boxes_solved_), "%", boxes_solved_});
    double sum = 0;
    for (const double value : on_turf_) sum += value;
    row.cells.push_back(
        {"on bare turf",
         on_turf_.empty() ? std::nan("") : 100 * sum / static_cast<double>(on_turf_.size()), "%",
         on_turf_.size()});
  }

  // The key orange, our pitch cyan, boxes green where held and red where not, the drawn lines
  // yellow.
  base::Status draw(std::int64_t number, const image::Frame& frame, const NotedFrame& noted,
                    const codec::CameraView& view) const {
    Overlay overlay(frame);
    if (view.matte) overlay.draw_matte(view.matte->alpha.view(), {255, 120, 0});
    if (!view.estimate.lost()) overlay.draw_pitch(view.estimate, pitch_, {0, 255, 255});
    for (const Segment& segment : noted.across)
      overlay.draw_line(segment[0], segment[1], {255, 255, 0}, 1);
    for (std::size_t i = 0; i < noted.turf.size(); ++i)
      overlay.draw_line(noted.turf[i], noted.turf[(i + 1) % noted.turf.size()], {255, 255, 0}, 1);
    for (const NotedBox& box : noted.people) {
      const bool held = view.matte && is_held(view.matte->alpha.view(), box);
      overlay.draw_box(box.low, box.high, held ? Colour{0, 255, 0} : Colour{255, 0, 0});
    }
    overlay.draw_text({20, frame.height() - 20.0},
                      fmt::format("{} frame {}: {}", video_.stem().string(), number + 1,
                                  geometry::name(view.estimate.evidence)),
                      {255, 255, 255});
    return overlay.write(options_.pictures /
                         fmt::format("broadcast-{}-{:04}.png", video_.stem().string(), number + 1));
  }

  fs::path video_;
  ClipNotes notes_;
  const SetOptions& options_;
  pitch::PitchModel pitch_ = *pitch::make_pitch(pitch::Sport::kSoccer, {});
  std::vector<CameraEstimate> cameras_;  // by frame
  std::map<std::int64_t, image::FramePtr> drawn_;
  std::vector<double> across_, on_turf_;
  std::array<std::vector<std::pair<CameraEstimate, EdgePoint>>, 4> edges_;
  std::size_t boxes_ = 0, boxes_solved_ = 0, held_ = 0;
};

}  // namespace

base::Result<SetReport> run_broadcast_clips(const SetOptions& options) {
  const fs::path folder = options.data / "broadcast-clips";
  std::error_code code;
  std::vector<fs::path> videos;
  for (fs::directory_iterator entry(folder, code), end; !code && entry != end;
       entry.increment(code))
    if (entry->path().extension() == ".mp4") videos.push_back(entry->path());
  if (videos.empty()) {
    return base::fail(base::ErrorKind::kNotFound, folder.string(), "is not there",
                      "set TOUCHLINE_DATA or --data to the folder of all sets");
  }
  std::sort(videos.begin(), videos.end());
  SetReport report;
  report.name = "broadcast-clips";
  report.what =
      "Television clips of a main camera through the edge's chain in this process, from a cold "
      "start, pitch sizes unknown; every tenth frame has people's boxes, the turf's outline and "
      "two lines parallel to the goal lines, drawn by hand.";
  for (const fs::path& video : videos) {
    auto notes = read_clip_notes(fs::path(video).replace_extension(".json"));
    if (!notes) return base::fail(notes.error());
    auto row = Clip(video, std::move(*notes), options).run(report);
    if (!row) return base::fail(row.error());
    report.rows.push_back(std::move(*row));
  }
  report.notes.insert(
      report.notes.begin(),
      {"pan'': size of the second difference of pan from frame to frame, over three solved frames",
       "across: distance of the ends of a drawn parallel from the image of the line across the "
       "pitch through its middle; outline: distance of the drawn foot of the hoardings from the "
       "image of one line parallel to the pitch's edges for the whole clip",
       "people held: boxes of which foreground covers a fifth and three quarters of the rows, of "
       "all boxes and of those in frames with a key; on bare turf: foreground on the outlined turf "
       "away from boxes"});
  return report;
}

}  // namespace touchline::score
