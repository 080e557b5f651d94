#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "tools/score/report.h"

namespace touchline::score {

namespace {

std::string figure(double value, int decimals) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : "-";
}

const char* arrow(Better better) {
  switch (better) {
    case Better::kLower:
      return "v";
    case Better::kHigher:
      return "^";
    case Better::kOne:
      break;
  }
  return "1";
}

bool is_shown(const Series& series, const TableOptions& options) {
  return options.each_person || !series.of_person || series.subject == "all";
}

}  // namespace

std::string table_text(const ScoreReport& report, const TableOptions& options) {
  std::string out = fmt::format("recording {}\n", report.recording);
  const auto to = std::back_inserter(out);
  std::size_t label = 0;
  std::size_t subject = 0;
  for (const Series& s : report.series) {
    if (!is_shown(s, options)) continue;
    label = std::max(label, s.kind.score.size());
    subject = std::max(subject, s.subject.size());
  }
  std::string group;
  std::string score;
  for (const Series& s : report.series) {
    if (!is_shown(s, options)) continue;
    if (s.kind.group != group) {
      group = s.kind.group;
      score.clear();
      fmt::format_to(to, "\n{:<{}}  {:<{}}  {:>4} {:>9} {:>20} {:>9} {:>9} {:>6} {}\n", group,
                     label + 2, "", subject, "unit", "figure", "95 % interval", "median", "p95",
                     "n", "   oracle");
    }
    const bool first = s.kind.score != score;
    score = s.kind.score;
    const int d = s.kind.decimals;
    const Summary& m = s.summary;
    const std::string interval =
        std::isfinite(m.ci_low) ? fmt::format("{} .. {}", figure(m.ci_low, d), figure(m.ci_high, d))
                                : "-";
    fmt::format_to(to, "{} {:<{}}  {:<{}}  {:>4} {:>9} {:>20} {:>9} {:>9} {:>6}",
                   first ? arrow(s.kind.better) : " ", first ? s.kind.score : "", label, s.subject,
                   subject, s.kind.unit, figure(m.mean, d), interval, figure(m.median, d),
                   figure(m.p95, d), m.n);
    if (s.oracle) fmt::format_to(to, " {:>9}", figure(s.oracle->mean, d));
    out += '\n';
  }
  out += "\n^ higher is better, v lower, 1 nearer to 1; intervals: block bootstrap over frames\n";
  if (!report.not_scored.empty()) out += "\nnot scored\n";
  for (const std::string& line : report.not_scored) fmt::format_to(to, "  {}\n", line);
  if (!report.notes.empty()) out += "\nnotes\n";
  for (const std::string& line : report.notes) fmt::format_to(to, "  {}\n", line);
  return out;
}

}  // namespace touchline::score
