#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/score/report.h"

namespace touchline::score {

namespace {

using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json summary_json(const Summary& s) {
  return {{"n", s.n},
          {"figure", number(s.mean)},
          {"median", number(s.median)},
          {"p95", number(s.p95)},
          {"ci_low", number(s.ci_low)},
          {"ci_high", number(s.ci_high)}};
}

}  // namespace

std::string json_text(const ScoreReport& report) {
  Json out;
  out["format_version"] = 1;
  out["recording"] = report.recording;
  out["series"] = Json::array();
  for (const Series& s : report.series) {
    Json row = {{"group", s.kind.group},
                {"score", s.kind.score},
                {"subject", s.subject},
                {"unit", s.kind.unit},
                {"better", name(s.kind.better)},
                {"statistic", name(s.kind.statistic)},
                {"summary", summary_json(s.summary)},
                {"oracle", s.oracle ? summary_json(*s.oracle) : Json(nullptr)}};
    Json samples = Json::array();
    if (!s.pooled) {
      for (const Sample& sample : s.samples) {
        samples.push_back({sample.frame, number(sample.value), number(sample.weight)});
      }
    }
    row["samples"] = std::move(samples);
    out["series"].push_back(std::move(row));
  }
  out["not_scored"] = report.not_scored;
  out["notes"] = report.notes;
  return out.dump(1);
}

}  // namespace touchline::score
