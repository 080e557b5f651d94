#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <system_error>
#include <utility>
#include <variant>

#include "hub/decode/decode_set.h"
#include "hub/session/session_reader.h"
#include "shared/image/colour.h"
#include "shared/recording/video_reader.h"
#include "tools/inspect/overlay.h"
#include "tools/inspect/pictures.h"

namespace touchline::inspect {
namespace {

namespace fs = std::filesystem;

bool wanted(const PictureOptions& options, std::int64_t frame) {
  if (options.frames.empty()) return frame % std::max(options.every, 1) == 0;
  return std::find(options.frames.begin(), options.frames.end(), frame) != options.frames.end();
}

// The views of one camera that are wanted, by the number of their frame in the video.
base::Result<std::map<std::uint64_t, codec::CameraView>> views_of(
    const session::SessionReader& session, const base::CameraId& camera,
    const PictureOptions& options) {
  std::map<std::uint64_t, codec::CameraView> views;
  for (std::size_t i = 0; i < session.instants().size(); ++i) {
    if (!wanted(options, session.frame_number(i))) continue;
    auto set = session.frame_set(i);
    if (!set) return base::fail(set.error());
    auto decoded = decode::decode_set(*set);
    if (!decoded) return base::fail(decoded.error());
    for (codec::CameraView& view : decoded->views)
      if (view.id.camera == camera) views.emplace(view.id.sequence, std::move(view));
  }
  return views;
}

}  // namespace

base::Result<int> session_pictures(const recording::Recording& recording, const fs::path& session,
                                   Layer layer, const fs::path& out, const PictureOptions& options,
                                   const std::function<void(const std::string&)>& progress) {
  auto reader = session::SessionReader::open(session);
  if (!reader) return base::fail(reader.error());
  pitch::PitchSizes sizes = recording.sizes;
  if (options.length_m) sizes.length_m = options.length_m;
  if (options.width_m) sizes.width_m = options.width_m;
  const auto pitch = pitch::make_pitch(recording.sport, sizes);
  if (!pitch) return base::fail(pitch.error());
  int count = 0;
  for (const recording::CameraEntry& entry : recording.cameras) {
    if (!options.cameras.empty() && std::find(options.cameras.begin(), options.cameras.end(),
                                              entry.id) == options.cameras.end())
      continue;
    auto views = views_of(*reader, entry.id, options);
    if (!views) return base::fail(views.error());
    if (views->empty()) continue;
    std::error_code error;
    fs::create_directories(out / entry.id.value, error);
    if (error) {
      return base::fail(base::ErrorKind::kIo, (out / entry.id.value).string(), error.message(),
                        "choose a folder that can be written");
    }
    auto video = recording::VideoReader::open(entry, recording, 0);
    if (!video) return base::fail(video.error());
    int of_camera = 0;
    while (!views->empty()) {
      auto frame = video->next();
      if (!frame) return base::fail(frame.error());
      if (!*frame) break;
      const auto view = views->find((*frame)->id.sequence);
      if (view == views->end()) continue;
      Picture picture = image::to_rgb(**frame);
      if (layer == Layer::kLines) {
        picture = lines_overlay(std::move(picture), view->second.estimate, *pitch);
      } else if (view->second.matte) {
        picture = key_overlay(picture, *view->second.matte);
      } else {
        draw::draw_label(picture, 8, 8, "no matte", draw::kMissing);
      }
      const fs::path file = out / entry.id.value / fmt::format("{:06}.png", view->first);
      if (auto status = draw::write_picture(file, draw::at_most(picture, options.width)); !status)
        return base::fail(status.error());
      views->erase(view);
      ++of_camera;
    }
    progress(fmt::format("{}: {} pictures", entry.id.value, of_camera));
    count += of_camera;
  }
  return count;
}

}  // namespace touchline::inspect
