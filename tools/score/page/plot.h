// Plots as inline SVG.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace touchline::score::page {

struct PlotPoint {
  double x = 0;
  double y = 0;
  std::string link;  // "#id" of a picture; empty = none
};

struct PlotLine {
  std::string name;
  std::vector<PlotPoint> points;  // by rising x
  std::optional<double> level;    // dashed: the oracle's figure
};

struct Plot {
  std::string title;
  std::string unit;
  std::string x_name = "frame";
  int decimals = 2;
  std::vector<PlotLine> lines;
};

// A colour for the line with this index; they repeat after ten.
std::string line_colour(std::size_t index);

// An <svg> element: axes with round ticks, a line each, its points with their values as tooltips.
// The value axis is logarithmic when few values dwarf all others. Values that are not finite are
// left out.
std::string plot_svg(const Plot& plot);

// Ticks at round values within [low, high], about `wanted` of them.
std::vector<double> round_ticks(double low, double high, int wanted);

// A small <svg>: interval as a bar, the figure as a dot, the oracle as a line, on one axis.
std::string interval_svg(double low, double high, double figure, std::optional<double> oracle,
                         double axis_low, double axis_high);

struct PlanPerson {
  std::string name;
  double x = 0;
  double y = 0;
  bool ball = false;
};

// The pitch from above with true people (rings), told ones (dots) and a line between those that the
// score takes for one, within `reach_m`. half_x and half_y: what is shown, metres from the centre.
std::string plan_svg(const std::vector<PlanPerson>& truth, const std::vector<PlanPerson>& told,
                     double reach_m, double half_length, double half_width);

}  // namespace touchline::score::page
