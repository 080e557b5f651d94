#include "edge/survey_report.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "edge/calibrate/survey/site_survey.h"
#include "edge/edge_config.h"

namespace touchline::edge {
namespace {

constexpr double kDegrees = 180 / 3.14159265358979323846;

// "length and width": what was stated and is not so.
std::string refuted_names(const calibrate::SurveyResult& result) {
  std::string names;
  for (const auto& [index, name] : {std::pair{0, "length"}, {1, "width"}, {2, "crown"}})
    if (result.refuted(index)) names += (names.empty() ? "" : " and ") + std::string(name);
  return names;
}

nlohmann::ordered_json json_of(const base::CameraId& camera,
                               const calibrate::SurveyResult& result) {
  const geometry::Mount& mount = result.mount;
  nlohmann::ordered_json out;
  out["camera"] = camera.value;
  out["position_m"] = {mount.position_in_world.x(), mount.position_in_world.y(),
                       mount.position_in_world.z()};
  out["position_sd_m"] = {std::sqrt(mount.covariance(0, 0)), std::sqrt(mount.covariance(1, 1)),
                          std::sqrt(mount.covariance(2, 2))};
  out["level_deg"] = {mount.level_x * kDegrees, mount.level_y * kDegrees};
  out["principal_point_px"] = {mount.cx, mount.cy};
  for (const geometry::LensKnot& knot : mount.lens)
    out["lens"].push_back({{"focal_px", knot.focal_px}, {"k1", knot.k1}, {"k2", knot.k2}});
  if (result.refuted.any()) {
    out["pitch"] = {{"length_m", result.length_m},
                    {"width_m", result.width_m},
                    {"crown_m", result.crown_m},
                    {"contradicts_stated", refuted_names(result)}};
  }
  out["rms_px"] = result.rms_px;
  out["stills"] = result.still_rms_px;
  out["solved"] = result.solved;
  return out;
}

std::string text_of(const base::CameraId& camera, const calibrate::SurveyResult& result) {
  const geometry::Mount& mount = result.mount;
  std::string text = fmt::format(
      "camera     {}\nposition   {:.3f} {:.3f} {:.3f} m (sd {:.3f} {:.3f} {:.3f})\nlevel      "
      "{:.3f} {:.3f} deg\nprincipal  {:.1f} {:.1f} px\n",
      camera.value, mount.position_in_world.x(), mount.position_in_world.y(),
      mount.position_in_world.z(), std::sqrt(mount.covariance(0, 0)),
      std::sqrt(mount.covariance(1, 1)), std::sqrt(mount.covariance(2, 2)),
      mount.level_x * kDegrees, mount.level_y * kDegrees, mount.cx, mount.cy);
  for (const geometry::LensKnot& knot : mount.lens)
    text += fmt::format("lens       f {:.0f} px  k1 {:.4f}  k2 {:.4f}\n", knot.focal_px, knot.k1,
                        knot.k2);
  for (std::size_t i = 0; i < result.stills.size(); ++i) {
    text +=
        fmt::format("still {:02}   {}\n", i,
                    result.stills[i].lost() ? "not solved"
                                            : fmt::format("rms {:.2f} px", result.still_rms_px[i]));
  }
  if (result.refuted.any())
    text += fmt::format(
        "pitch      {:.2f} x {:.2f} m, crown {:.2f} m by the lines, which contradict the stated "
        "{}: measure it and state its sizes\n",
        result.length_m, result.width_m, result.crown_m, refuted_names(result));
  return text + fmt::format("solved     {} of {}, rms {:.2f} px\n", result.solved,
                            result.stills.size(), result.rms_px);
}

nlohmann::ordered_json json_of(const calibrate::SiteSurveyResult& site) {
  nlohmann::ordered_json out;
  out["pitch"] = {{"length_m", site.pitch.length_m},
                  {"width_m", site.pitch.width_m},
                  {"crown_m", site.pitch.crown_m}};
  out["pitch_sd"] = {{"length_m", site.size_sigma_m(0)},
                     {"width_m", site.size_sigma_m(1)},
                     {"crown_m", site.size_sigma_m(2)}};
  for (const calibrate::SiteCameraSurvey& camera : site.cameras) {
    nlohmann::ordered_json row;
    if (camera.survey) {
      row = json_of(camera.camera, *camera.survey);
    } else {
      row["camera"] = camera.camera.value;
      row["trouble"] = base::to_string(camera.survey.error());
    }
    row["says_m"] = {camera.size_m(0), camera.size_m(1), camera.size_m(2)};
    row["says_sd_m"] = {camera.size_sigma_m(0), camera.size_sigma_m(1), camera.size_sigma_m(2)};
    row["off_sigmas"] = camera.off_sigmas;
    row["used_for_sizes"] = camera.used;
    out["cameras"].push_back(std::move(row));
  }
  return out;
}

std::string text_of(const calibrate::SiteSurveyResult& site) {
  std::string text =
      fmt::format("pitch      {:.2f} x {:.2f} m, crown {:.2f} m (sd {:.3f} {:.3f} {:.3f})\n",
                  site.pitch.length_m, site.pitch.width_m, site.pitch.crown_m, site.size_sigma_m(0),
                  site.size_sigma_m(1), site.size_sigma_m(2));
  for (const calibrate::SiteCameraSurvey& camera : site.cameras) {
    text += "\n";
    if (camera.survey) {
      text += text_of(camera.camera, *camera.survey);
    } else {
      text += fmt::format("camera     {}\nnot solved {}\n", camera.camera.value,
                          base::to_string(camera.survey.error()));
    }
    if (camera.size_sigma_m.isZero()) continue;
    text += fmt::format(
        "by itself  {:.2f} x {:.2f} m, crown {:.2f} m (sd {:.3f} {:.3f} {:.3f}){}\n",
        camera.size_m(0), camera.size_m(1), camera.size_m(2), camera.size_sigma_m(0),
        camera.size_sigma_m(1), camera.size_sigma_m(2),
        camera.used ? ""
                    : fmt::format(", {:.1f} sigma off the others and not used: check its stills "
                                  "and its side",
                                  camera.off_sigmas));
  }
  text += fmt::format(
      "\nfor recording.toml:\n[pitch]\nlength_m = {:.2f}\nwidth_m = {:.2f}\ncrown_m = {:.2f}\n",
      site.pitch.length_m, site.pitch.width_m, site.pitch.crown_m);
  return text;
}

}  // namespace

base::Result<std::string> survey_camera_report(const recording::Recording& recording,
                                               const base::CameraId& camera,
                                               const ChainOptions& options, bool json) {
  auto setup = chain_setup(recording, camera);
  if (!setup) return base::fail(setup.error());
  SurveyStills stills = load_stills(*recording.find(camera));
  if (stills.frames.empty()) {
    return base::fail(stills.troubles.empty()
                          ? base::Error{base::ErrorKind::kConfiguration, camera.value,
                                        "has no survey stills",
                                        "put 12 to 16 stills of the empty pitch in its survey "
                                        "folder, over the whole range of the head"}
                          : stills.troubles.front());
  }
  const auto result = survey_mount(*setup, options, stills.frames);
  if (!result) return base::fail(result.error());
  return json ? json_of(camera, *result).dump() + "\n" : text_of(camera, *result);
}

base::Result<std::string> survey_site_report(
    const recording::Recording& recording, const ChainOptions& options, bool json,
    const std::function<void(const std::string&)>& progress) {
  auto pitch = pitch::make_pitch(recording.sport, recording.sizes);
  if (!pitch) return base::fail(pitch.error());
  calibrate::SiteSurveyOptions site_options;
  site_options.survey = options.mount.survey;
  site_options.survey.length_stated = recording.sizes.length_m.has_value();
  site_options.survey.width_stated = recording.sizes.width_m.has_value();
  site_options.survey.crown_stated = recording.sizes.crown_m.has_value();
  calibrate::SiteSurvey survey(std::move(*pitch), site_options);
  for (const recording::CameraEntry& entry : recording.cameras) {
    SurveyStills stills = load_stills(entry);
    for (const base::Error& trouble : stills.troubles) progress(base::to_string(trouble));
    if (stills.frames.empty()) continue;
    const auto setup = chain_setup(recording, entry.id);
    if (!setup) return base::fail(setup.error());
    progress(fmt::format("{}: {} stills", entry.id.value, stills.frames.size()));
    compensate_stills(options.detail, stills.frames);
    if (base::Status added = survey.add(entry.id, setup->side, stills.frames); !added)
      progress(base::to_string(added.error()));
  }
  progress("solving");
  const auto site = survey.solve();
  if (!site) return base::fail(site.error());
  return json ? json_of(*site).dump() + "\n" : text_of(*site);
}

}  // namespace touchline::edge
