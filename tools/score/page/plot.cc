#include "tools/score/page/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "tools/score/page/html_text.h"

namespace touchline::score::page {

namespace {

constexpr double kWidth = 620, kHeight = 210;
constexpr double kLeft = 52, kRight = 12, kTop = 10, kBottom = 26;
constexpr std::size_t kMostTooltips = 1500;

struct Axis {
  double low = 0, high = 1;
  bool logarithmic = false;
  double place(double value) const {  // 0..1
    if (logarithmic) {
      return (std::log10(std::max(value, low)) - std::log10(low)) /
             (std::log10(high) - std::log10(low));
    }
    return (value - low) / (high - low);
  }
};

Axis value_axis(const std::vector<double>& values, bool share) {
  Axis axis;
  if (values.empty()) return axis;
  std::vector<double> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  axis.low = sorted.front();
  axis.high = sorted.back();
  const double usual = sorted[sorted.size() * 9 / 10];
  if (sorted.front() > 0 && axis.high > 25 * usual && axis.high > 25 * axis.low) {
    axis.logarithmic = true;
    axis.low = std::pow(10, std::floor(std::log10(axis.low)));
    axis.high = std::pow(10, std::ceil(std::log10(axis.high)));
    return axis;
  }
  // From zero unless that would flatten everything.
  if (axis.low > 0 && axis.low < 0.6 * axis.high) axis.low = 0;
  double room = 0.06 * (axis.high - axis.low);
  if (!(room > 1e-12 * std::abs(axis.high))) room = std::max(1e-3, 0.05 * std::abs(axis.high));
  if (axis.low != 0) axis.low -= room;
  axis.high += room;
  if (share && sorted.back() <= 100) axis.high = std::min(axis.high, 100.0);
  return axis;
}

std::vector<double> value_ticks(const Axis& axis) {
  if (!axis.logarithmic) return round_ticks(axis.low, axis.high, 5);
  std::vector<double> out;
  for (double v = axis.low; v <= axis.high * 1.001; v *= 10) out.push_back(v);
  return out;
}

std::string shortest(double value) { return fmt::format("{:.5g}", value); }

}  // namespace

std::string line_colour(std::size_t index) {
  static constexpr std::array<const char*, 10> kColours = {
      "#2563c9", "#d9480f", "#2b8a3e", "#9c36b5", "#b58a00",
      "#0b7285", "#c2255c", "#5c5f66", "#6741d9", "#7a4a1d"};
  return kColours[index % kColours.size()];
}

std::vector<double> round_ticks(double low, double high, int wanted) {
  std::vector<double> out;
  if (!(high > low) || wanted < 1 || !std::isfinite(high - low)) return out;
  const double raw = (high - low) / wanted;
  const double power = std::pow(10, std::floor(std::log10(raw)));
  double step = 10 * power;
  for (const double s : {1.0, 2.0, 2.5, 5.0}) {
    if (s * power >= raw * 0.999) {
      step = s * power;
      break;
    }
  }
  const double first = std::ceil(low / step - 1e-9);
  for (int i = 0; i <= 4 * wanted + 4; ++i) {
    const double v = (first + i) * step;
    if (v > high + 1e-9 * step) break;
    out.push_back(std::abs(v) < 1e-9 * step ? 0 : v);
  }
  return out;
}

std::string plot_svg(const Plot& plot) {
  std::vector<double> values;
  double first = std::numeric_limits<double>::infinity();
  double last = -first;
  std::size_t count = 0;
  for (const PlotLine& line : plot.lines) {
    for (const PlotPoint& p : line.points) {
      if (!std::isfinite(p.y)) continue;
      values.push_back(p.y);
      first = std::min(first, p.x);
      last = std::max(last, p.x);
      ++count;
    }
    if (line.level && std::isfinite(*line.level)) values.push_back(*line.level);
  }
  std::string out;
  const auto to = std::back_inserter(out);
  fmt::format_to(to, "<svg class=\"plot\" viewBox=\"0 0 {} {}\" role=\"img\">", kWidth, kHeight);
  fmt::format_to(to, "<title>{}</title>", escaped(plot.title));
  if (count == 0) {
    fmt::format_to(to, "<text x=\"{}\" y=\"{}\" class=\"none\">no values</text></svg>", kLeft,
                   kHeight / 2);
    return out;
  }
  const Axis y = value_axis(values, plot.unit == "%");
  Axis x;
  x.low = first;
  x.high = last > first ? last : first + 1;
  const auto px = [&](double v) { return kLeft + x.place(v) * (kWidth - kLeft - kRight); };
  const auto py = [&](double v) {
    return kHeight - kBottom - y.place(v) * (kHeight - kTop - kBottom);
  };
  for (const double tick : value_ticks(y)) {
    fmt::format_to(to,
                   "<line class=\"grid\" x1=\"{}\" y1=\"{:.1f}\" x2=\"{}\" y2=\"{:.1f}\"/>"
                   "<text class=\"tick\" x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>",
                   kLeft, py(tick), kWidth - kRight, py(tick), kLeft - 6, py(tick) + 4,
                   shortest(tick));
  }
  for (const double tick : round_ticks(x.low, x.high, 8)) {
    if (tick != std::round(tick)) continue;
    fmt::format_to(to,
                   "<text class=\"tick\" x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                   px(tick), kHeight - 10, shortest(tick));
  }
  for (std::size_t i = 0; i < plot.lines.size(); ++i) {
    const PlotLine& line = plot.lines[i];
    const std::string colour = line_colour(i);
    fmt::format_to(to, "<g class=\"line\" style=\"color:{}\"><title>{}</title>", colour,
                   escaped(line.name));
    if (line.level && std::isfinite(*line.level)) {
      fmt::format_to(to,
                     "<line class=\"oracle\" x1=\"{}\" y1=\"{:.1f}\" x2=\"{}\" y2=\"{:.1f}\">"
                     "<title>{}: oracle {}</title></line>",
                     kLeft, py(*line.level), kWidth - kRight, py(*line.level), escaped(line.name),
                     figure(*line.level, plot.decimals));
    }
    std::string points;
    for (const PlotPoint& p : line.points) {
      if (std::isfinite(p.y)) points += fmt::format("{:.1f},{:.1f} ", px(p.x), py(p.y));
    }
    fmt::format_to(to, "<polyline points=\"{}\"/>", points);
    for (const PlotPoint& p : line.points) {
      if (!std::isfinite(p.y) || (count > kMostTooltips && p.link.empty())) continue;
      if (!p.link.empty()) fmt::format_to(to, "<a href=\"{}\">", escaped(p.link));
      fmt::format_to(
          to,
          "<circle class=\"{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\"><title>{}, {} {:g}: "
          "{} {}</title></circle>",
          p.link.empty() ? "point" : "worst", px(p.x), py(p.y), p.link.empty() ? 2.2 : 4.5,
          escaped(line.name), escaped(plot.x_name), p.x, figure(p.y, plot.decimals),
          escaped(plot.unit));
      if (!p.link.empty()) out += "</a>";
    }
    out += "</g>";
  }
  fmt::format_to(to, "<text class=\"axis\" x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text></svg>",
                 kWidth - kRight, kHeight - 10, escaped(plot.x_name));
  return out;
}

std::string interval_svg(double low, double high, double value, std::optional<double> oracle,
                         double axis_low, double axis_high) {
  constexpr double kBar = 130;
  std::string out;
  const auto to = std::back_inserter(out);
  out += "<svg class=\"interval\" viewBox=\"-4 0 138 16\" role=\"img\">";
  const double span = axis_high - axis_low;
  const auto at = [&](double v) {
    return span > 0 ? std::clamp((v - axis_low) / span, 0.0, 1.0) * kBar : kBar / 2;
  };
  fmt::format_to(to, "<line class=\"rail\" x1=\"0\" y1=\"8\" x2=\"{}\" y2=\"8\"/>", kBar);
  if (std::isfinite(low) && std::isfinite(high)) {
    fmt::format_to(to, "<line class=\"bar\" x1=\"{:.1f}\" y1=\"8\" x2=\"{:.1f}\" y2=\"8\"/>",
                   at(low), std::max(at(high), at(low) + 1));
  }
  if (oracle && std::isfinite(*oracle)) {
    fmt::format_to(to, "<line class=\"ideal\" x1=\"{0:.1f}\" y1=\"1\" x2=\"{0:.1f}\" y2=\"15\"/>",
                   at(*oracle));
  }
  if (std::isfinite(value))
    fmt::format_to(to, "<circle cx=\"{:.1f}\" cy=\"8\" r=\"3.2\"/>", at(value));
  return out + "</svg>";
}

std::string plan_svg(const std::vector<PlanPerson>& truth, const std::vector<PlanPerson>& told,
                     double reach_m, double half_length, double half_width) {
  std::string out;
  const auto to = std::back_inserter(out);
  const double hx = half_length + 4;
  const double hy = half_width + 4;
  fmt::format_to(to, "<svg class=\"plan\" viewBox=\"{:.2f} {:.2f} {:.2f} {:.2f}\" role=\"img\">",
                 -hx, -hy, 2 * hx, 2 * hy);
  fmt::format_to(
      to,
      "<rect class=\"turf\" x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\"/>"
      "<rect class=\"paint\" x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" "
      "height=\"{:.2f}\"/><line class=\"paint\" x1=\"0\" y1=\"{:.2f}\" x2=\"0\" y2=\"{:.2f}\"/>",
      -hx, -hy, 2 * hx, 2 * hy, -half_length, -half_width, 2 * half_length, 2 * half_width,
      -half_width, half_width);
  for (const PlanPerson& t : truth) {  // the far side is up
    const PlanPerson* nearest = nullptr;
    double best = reach_m;
    for (const PlanPerson& f : told) {
      const double d = std::hypot(f.x - t.x, f.y - t.y);
      if (f.ball == t.ball && d <= best) {
        best = d;
        nearest = &f;
      }
    }
    if (nearest != nullptr) {
      fmt::format_to(
          to, "<line class=\"pair\" x1=\"{:.2f}\" y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\"/>", t.x,
          -t.y, nearest->x, -nearest->y);
    }
    fmt::format_to(to,
                   "<circle class=\"{}\" cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{}\"><title>{}, true: "
                   "{:.2f}, {:.2f} m{}</title></circle>",
                   nearest != nullptr ? "true" : "true alone", t.x, -t.y, t.ball ? 0.5 : 0.9,
                   escaped(t.name), t.x, t.y,
                   nearest != nullptr ? fmt::format("; told {:.2f} m away", best)
                                      : std::string("; nobody told within reach"));
  }
  for (const PlanPerson& f : told) {
    fmt::format_to(
        to,
        "<circle class=\"told\" cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{}\"><title>{}, told: {:.2f}, "
        "{:.2f} m</title></circle>",
        f.x, -f.y, f.ball ? 0.25 : 0.45, escaped(f.name), f.x, f.y);
  }
  return out + "</svg>";
}

}  // namespace touchline::score::page
