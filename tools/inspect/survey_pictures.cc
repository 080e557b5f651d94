#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "edge/edge_config.h"
#include "shared/image/colour.h"
#include "tools/inspect/overlay.h"
#include "tools/inspect/pictures.h"

namespace touchline::inspect {

namespace fs = std::filesystem;

base::Result<int> survey_pictures(const recording::Recording& recording, const fs::path& out,
                                  const PictureOptions& options,
                                  const std::function<void(const std::string&)>& progress) {
  recording::Recording site = recording;
  if (options.length_m) site.sizes.length_m = options.length_m;
  if (options.width_m) site.sizes.width_m = options.width_m;
  auto pitch = pitch::make_pitch(site.sport, site.sizes);
  if (!pitch) return base::fail(pitch.error());
  std::vector<PlacedHead> heads;
  int count = 0;
  for (const recording::CameraEntry& entry : site.cameras) {
    if (!options.cameras.empty() && std::find(options.cameras.begin(), options.cameras.end(),
                                              entry.id) == options.cameras.end())
      continue;
    edge::SurveyStills stills = edge::load_stills(entry);
    for (const base::Error& trouble : stills.troubles) progress(base::to_string(trouble));
    if (stills.frames.empty()) continue;
    const auto setup = edge::chain_setup(site, entry.id);
    if (!setup) return base::fail(setup.error());
    auto survey = edge::survey_mount(*setup, {}, stills.frames);
    if (!survey) {
      progress(fmt::format("{}: {}", entry.id.value, base::to_string(survey.error())));
      continue;
    }
    std::error_code error;
    fs::create_directories(out / entry.id.value, error);
    if (error) {
      return base::fail(base::ErrorKind::kIo, (out / entry.id.value).string(), error.message(),
                        "choose a folder that can be written");
    }
    for (std::size_t i = 0; i < stills.frames.size(); ++i) {
      const Picture picture =
          lines_overlay(image::to_rgb(stills.frames[i]), survey->stills[i], *pitch);
      const fs::path file = out / entry.id.value / fmt::format("{:02}.png", i);
      if (auto status = draw::write_picture(file, draw::at_most(picture, options.width)); !status)
        return base::fail(status.error());
      ++count;
    }
    progress(fmt::format("{}: {} of {} stills solved, rms {:.2f} px", entry.id.value,
                         survey->solved, stills.frames.size(), survey->rms_px));
    heads.push_back({entry.id, std::move(*survey)});
  }
  if (heads.empty()) {
    return base::fail(base::ErrorKind::kNumerical, "survey", "no head could be placed",
                      "take 12 to 16 stills of the empty pitch a head, and check side and sizes");
  }
  if (auto status = draw::write_picture(out / "plan.png",
                                        draw::at_most(site_plan(heads, *pitch), options.width));
      !status)
    return base::fail(status.error());
  return count + 1;
}

}  // namespace touchline::inspect
