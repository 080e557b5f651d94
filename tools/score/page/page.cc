#include "tools/score/page/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "tools/score/page/figures.h"
#include "tools/score/page/html_text.h"
#include "tools/score/page/page_style.h"
#include "tools/score/page/plot.h"

namespace touchline::score {

namespace {

using page::escaped;
using page::figure;

// The series of one score: "all" first where there are several subjects.
using Kind = std::span<const Series>;

std::vector<Kind> kinds_of(const std::vector<Series>& series) {
  std::vector<Kind> out;
  for (std::size_t begin = 0; begin < series.size();) {
    std::size_t end = begin;
    while (end < series.size() && series[end].kind.group == series[begin].kind.group &&
           series[end].kind.score == series[begin].kind.score) {
      ++end;
    }
    out.push_back(Kind(series).subspan(begin, end - begin));
    begin = end;
  }
  return out;
}

std::string sign(Better better) {
  switch (better) {
    case Better::kLower:
      return "<span title=\"lower is better\">&#8595;</span>";
    case Better::kHigher:
      return "<span title=\"higher is better\">&#8593;</span>";
    case Better::kOne:
      break;
  }
  return "<span title=\"the nearer to 1 the better\">&#8594;1</span>";
}

// Where the pictures of worst frames are: group, subject and frame to the id in the page.
using Links = std::map<std::string, std::string>;

std::string key(const std::string& group, const std::string& subject, std::int64_t frame) {
  return fmt::format("{}/{}/{}", group, subject, frame);
}

std::pair<double, double> axis_of(const Kind& kind) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  const auto take = [&](double v) {
    if (!std::isfinite(v)) return;
    low = std::min(low, v);
    high = std::max(high, v);
  };
  for (const Series& s : kind) {
    take(s.summary.mean);
    take(s.summary.ci_low);
    take(s.summary.ci_high);
    if (s.oracle) take(s.oracle->mean);
  }
  return {low, high};
}

void table_row(const Series& s, bool first, const std::pair<double, double>& axis,
               std::string& out) {
  const auto to = std::back_inserter(out);
  const int d = s.kind.decimals;
  const Summary& m = s.summary;
  const std::optional<double> oracle = s.oracle ? std::optional(s.oracle->mean) : std::nullopt;
  fmt::format_to(to, "<tr class=\"{}\"><th>{}</th><td class=\"subject\">{}</td>",
                 first ? "head" : "sub",
                 first ? sign(s.kind.better) + " " + escaped(s.kind.score) : std::string(),
                 escaped(s.subject));
  fmt::format_to(
      to,
      "<td class=\"figure\">{}<small> {}</small></td><td class=\"range\">{} &#8230; {}</td>"
      "<td>{}</td><td>{}</td><td>{}</td><td>{}</td><td class=\"n\">{}</td></tr>\n",
      figure(m.mean, d), escaped(s.kind.unit), figure(m.ci_low, d), figure(m.ci_high, d),
      page::interval_svg(m.ci_low, m.ci_high, m.mean, oracle, axis.first, axis.second),
      oracle ? figure(*oracle, d) : std::string(), figure(m.median, d), figure(m.p95, d), m.n);
}

std::string table(const std::vector<Kind>& kinds) {
  std::string out =
      "<table><thead><tr><th>score</th><th>of</th><th>figure</th><th>95 % interval</th><th></th>"
      "<th>oracle</th><th>median</th><th>95th %</th><th>n</th></tr></thead>\n";
  std::string group;
  for (const Kind& kind : kinds) {
    if (kind.front().kind.group != group) {
      group = kind.front().kind.group;
      out += fmt::format(
          "<tbody class=\"group\"><tr><th colspan=\"9\"><a "
          "href=\"#g-{}\">{}</a></th></tr></tbody>\n",
          page::plain(group), escaped(group));
    }
    const auto axis = axis_of(kind);
    out += kind.size() > 1 ? "<tbody class=\"kind many\">" : "<tbody class=\"kind\">";
    for (std::size_t i = 0; i < kind.size(); ++i) table_row(kind[i], i == 0, axis, out);
    out += "</tbody>\n";
  }
  return out + "</table>\n";
}

// The mean of the samples of each frame.
std::vector<page::PlotPoint> points_of(const Series& series, const Links& links) {
  std::map<std::int64_t, std::pair<double, double>> frames;
  for (const Sample& s : series.samples) {
    if (!std::isfinite(s.value)) continue;
    auto& [sum, weight] = frames[s.frame];
    const double w = series.kind.statistic == Statistic::kTotal ? 1 : s.weight;
    sum += w * s.value;
    weight += w;
  }
  std::vector<page::PlotPoint> out;
  for (const auto& [frame, sums] : frames) {
    const auto link = links.find(key(series.kind.group, series.subject, frame));
    const bool total = series.kind.statistic == Statistic::kTotal;
    if (!total && !(sums.second > 0)) continue;
    out.push_back({static_cast<double>(frame), total ? sums.first : sums.first / sums.second,
                   link == links.end() ? std::string() : "#" + link->second});
  }
  return out;
}

// Whether there is anything to see that the table does not tell.
bool moves(const page::Plot& plot) {
  std::size_t longest = 0;
  std::set<double> values;
  for (const page::PlotLine& line : plot.lines) {
    longest = std::max(longest, line.points.size());
    for (const page::PlotPoint& point : line.points) values.insert(point.y);
  }
  return longest > 1 && values.size() > 1;
}

std::string plot(const Kind& kind, const Links& links) {
  constexpr std::size_t kMostNamed = 10;
  page::Plot plot;
  plot.title = kind.front().kind.score;
  plot.unit = kind.front().kind.unit;
  plot.decimals = kind.front().kind.decimals;
  for (const Series& s : kind) {
    if (s.subject == "all" && kind.size() > 1) continue;
    plot.lines.push_back(
        {s.subject, points_of(s, links), s.oracle ? std::optional(s.oracle->mean) : std::nullopt});
  }
  if (!moves(plot)) return {};
  std::string out =
      fmt::format("<figure class=\"chart\"><figcaption>{} {}<small> {}</small>",
                  sign(kind.front().kind.better), escaped(plot.title), escaped(plot.unit));
  if (plot.lines.size() > 1 && plot.lines.size() <= kMostNamed) {
    out += "<span class=\"legend\">";
    for (std::size_t i = 0; i < plot.lines.size(); ++i) {
      out += fmt::format("<i style=\"color:{}\">&#9632;</i>{} ", page::line_colour(i),
                         escaped(plot.lines[i].name));
    }
    out += "</span>";
  }
  return out + "</figcaption>" + page::plot_svg(plot) + "</figure>\n";
}

std::string shot(const page::Shot& s) {
  const std::string picture =
      s.file.empty()
          ? s.svg
          : fmt::format("<a href=\"{0}\"><img src=\"{0}\" alt=\"{1}\" loading=\"lazy\"></a>",
                        escaped(s.file), escaped(s.what));
  return fmt::format("<div class=\"shot{}\">{}<p>{}</p></div>\n", s.wide ? " wide" : "", picture,
                     escaped(s.what));
}

std::string picture_section(const page::Figure& f) {
  std::string out =
      fmt::format("<section class=\"worst\" id=\"{}\"><h3>{} &#183; frame {}</h3>\n<ul>",
                  f.frame.id(), escaped(f.frame.subject), f.frame.frame);
  for (const std::string& reason : f.frame.reasons) out += "<li>" + escaped(reason) + "</li>";
  out += "</ul>\n";
  if (!f.missing.empty()) out += "<p class=\"none\">No picture: " + escaped(f.missing) + "</p>\n";
  out += "<div class=\"shots\">";
  for (const page::Shot& s : f.shots) out += shot(s);
  if (f.blink.size() == 2) {
    out += fmt::format(
        "<div class=\"shot\"><div class=\"blink\"><img src=\"{}\" alt=\"ours\" "
        "loading=\"lazy\"><img "
        "class=\"over\" src=\"{}\" alt=\"clean\" loading=\"lazy\"></div><p>Press the picture: "
        "ours, "
        "clean in turn. <b class=\"which\">ours</b></p></div>\n",
        escaped(f.blink[0].file), escaped(f.blink[1].file));
  }
  return out + "</div></section>\n";
}

std::string lines(const std::string& title, const std::vector<std::string>& items) {
  if (items.empty()) return {};
  std::string out = "<h2>" + title + "</h2>\n<ul class=\"notes\">";
  for (const std::string& item : items) out += "<li>" + escaped(item) + "</li>\n";
  return out + "</ul>\n";
}

base::Status write_text(const std::filesystem::path& path, std::string_view text) {
  std::ofstream file(path, std::ios::binary);
  file.write(text.data(), static_cast<std::streamsize>(text.size()));
  file.close();
  if (file) return {};
  return base::fail(base::ErrorKind::kIo, path.string(), "cannot be written",
                    "check the folder and the space on its disk");
}

}  // namespace

base::Status write_page(const ScoreReport& report, const recording::Recording& recording,
                        const Truth& truth, const PageOptions& options) {
  if (options.worst_of_each > 20) {
    return base::fail(base::ErrorKind::kArgument, "worst_of_each",
                      fmt::format("{} is outside 0..20", options.worst_of_each));
  }
  const auto figures = page::make_figures(page::worst_frames(report.series, options.worst_of_each),
                                          recording, truth, options);
  if (!figures) return base::fail(figures.error());
  Links links;
  for (const page::Figure& f : *figures) {
    links[key(f.frame.group, f.frame.subject, f.frame.frame)] = f.frame.id();
  }
  const std::vector<Kind> kinds = kinds_of(report.series);
  const std::string title = escaped(report.recording);
  std::string out = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\"><title>Scores of {}</title>\n<style>{}"
      "</style></head><body>\n<header><h1>{}</h1><p>{} cameras, {} virtual; scores of a session "
      "against the truth</p></header>\n<nav>",
      title, page::kStyle, title, recording.cameras.size(), truth.virtual_cameras().size());
  std::vector<std::string> groups;
  for (const Kind& kind : kinds) {
    if (groups.empty() || groups.back() != kind.front().kind.group) {
      groups.push_back(kind.front().kind.group);
    }
  }
  for (const std::string& group : groups) {
    out += fmt::format("<a href=\"#g-{}\">{}</a>", page::plain(group), escaped(group));
  }
  out +=
      "</nav>\n<main>\n<p class=\"key\">Dot: the figure. Bar: its 95 % interval. Upright line: the "
      "oracle, our renderer with true cameras and true mattes. Press a row to see single "
      "cameras, people and views.</p>\n";
  out += table(kinds);
  for (const std::string& group : groups) {
    out += fmt::format("<h2 id=\"g-{}\">{}</h2>\n<div class=\"charts\">", page::plain(group),
                       escaped(group));
    for (const Kind& kind : kinds) {
      if (kind.front().kind.group == group) out += plot(kind, links);
    }
    out += "</div>\n";
    for (const page::Figure& f : *figures) {
      if (f.frame.group == group) out += picture_section(f);
    }
  }
  out += lines("Not scored", report.not_scored) + lines("Notes", report.notes);
  out += fmt::format("</main>\n<script>{}</script>\n</body></html>\n", page::kScript);
  return write_text(options.folder / "index.html", out);
}

}  // namespace touchline::score
