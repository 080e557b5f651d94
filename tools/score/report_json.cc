#include <nlohmann/json.hpp>

#include "tools/score/report.h"

namespace touchline::score {

std::string json_text(const ScoreReport& report) {
  using Json = nlohmann::ordered_json;
  Json out;
  out["recording"] = report.recording;
  out["cameras"] = Json::array();
  for (const CameraScore& c : report.cameras) {
    out["cameras"].push_back({{"id", c.camera},
                              {"frames", c.frames},
                              {"solved", c.solved},
                              {"rms_median_px", c.median_px},
                              {"rms_p95_px", c.p95_px},
                              {"rms_worst_px", c.worst_px}});
  }
  out["mattes"] = Json::array();
  for (const MatteScore& m : report.mattes) {
    out["mattes"].push_back({{"camera", m.camera},
                             {"frames", m.frames},
                             {"missing_frames", m.missing},
                             {"iou", m.iou()},
                             {"boundary_px", m.mean_boundary_px()},
                             {"missing_share", m.missing_share()},
                             {"extra_share", m.extra_share()},
                             {"alpha_error", m.mean_alpha_error()}});
  }
  out["hulls"] = Json::array();
  for (const HullScore& h : report.hulls) {
    Json people = Json::array();
    for (const PersonInside& p : h.people) {
      people.push_back({{"id", p.person}, {"inside", p.share}, {"vertices", p.vertices}});
    }
    out["hulls"].push_back({{"frame", h.frame},
                            {"least_inside", h.least_share()},
                            {"mean_inside", h.mean_share()},
                            {"all_inside", h.all_share},
                            {"components", h.components},
                            {"phantoms", h.phantoms},
                            {"volume_m3", h.volume_m3},
                            {"people", people}});
  }
  if (report.people) {
    const PeopleScore& p = *report.people;
    out["people"] = {{"frames", p.frames},         {"expected", p.expected},
                     {"found", p.found},           {"extra", p.extra},
                     {"id_changes", p.id_changes}, {"median_m", p.median_m},
                     {"p95_m", p.p95_m},           {"ball_frames", p.ball_frames},
                     {"ball_found", p.ball_found}, {"ball_median_m", p.ball_median_m}};
  }
  out["views"] = Json::array();
  for (const CameraViews& v : report.views) {
    Json frames = Json::array();
    for (const ViewScore& s : v.frames) {
      frames.push_back({{"frame", s.frame},
                        {"psnr_db", s.psnr_db},
                        {"ssim", s.ssim},
                        {"shift_px", {s.shift_px.x(), s.shift_px.y()}},
                        {"shifted_psnr_db", s.shifted_psnr_db},
                        {"full_psnr_db", s.full_psnr_db},
                        {"full_ssim", s.full_ssim}});
    }
    out["views"].push_back({{"camera", v.camera}, {"frames", frames}});
  }
  out["not_scored"] = report.not_scored;
  return out.dump(2);
}

}  // namespace touchline::score
