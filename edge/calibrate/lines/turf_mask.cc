#include <algorithm>
#include <cmath>
#include <vector>

#include "edge/calibrate/lines/turf_mask_internal.h"

namespace touchline::calibrate {
namespace {

constexpr int kStep = LineMap::kTurfStep;
constexpr int kHueBins = 72;
constexpr double kPi = 3.14159265358979323846;

struct Cell {
  float y = 0;
  float cb = 0;
  float cr = 0;
};

std::vector<Cell> cell_means(const image::Frame& frame, int columns, int rows) {
  const image::ChromaShift shift = image::chroma_shift(frame.format);
  std::vector<Cell> cells(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const int x0 = c * kStep;
      const int y0 = r * kStep;
      const int x1 = std::min(x0 + kStep, frame.width());
      const int y1 = std::min(y0 + kStep, frame.height());
      int sum_y = 0, sum_cb = 0, sum_cr = 0, count = 0;
      for (int y = y0; y < y1; y += 2) {
        const std::uint16_t* luma = frame.planes[0].row(y);
        const std::uint16_t* cb = frame.planes[1].row(y >> shift.y);
        const std::uint16_t* cr = frame.planes[2].row(y >> shift.y);
        for (int x = x0; x < x1; x += 2) {
          sum_y += luma[x];
          sum_cb += cb[x >> shift.x];
          sum_cr += cr[x >> shift.x];
          ++count;
        }
      }
      const float scale = 1.0F / static_cast<float>(std::max(count, 1));
      cells[static_cast<std::size_t>(r * columns + c)] = {static_cast<float>(sum_y) * scale,
                                                          static_cast<float>(sum_cb) * scale - 512,
                                                          static_cast<float>(sum_cr) * scale - 512};
    }
  }
  return cells;
}

double hue(double cb, double cr) {
  const double angle = std::atan2(cr, cb);
  return angle < 0 ? angle + 2 * kPi : angle;
}

// Turf lies between yellow-green and blue-green: BT.709 green is at 230 degrees here.
constexpr double kLeastHue = 172 * kPi / 180;
constexpr double kMostHue = 278 * kPi / 180;
constexpr double kLeastSaturation = 14;
constexpr double kLeastShare = 0.02;              // of the cells, to be the turf's colour
constexpr double kLeastOtherShare = 0.04;         // the same of turf in another light
constexpr double kMostShadeHue = 45 * kPi / 180;  // between turf in the sun and in shade
constexpr double kMostUneven = 0.08;              // step between cells over the luma above black
constexpr double kDarker = 0.85;
constexpr double kSameHue = 12 * kPi / 180;  // cells this near the first colour are of it
constexpr double kSameLeast = 0.55;          // the same, of saturation
constexpr double kSameMost = 1.8;
constexpr double kBlack = 64;

struct TurfColour {
  double hue = 0;
  double saturation = 0;
};

// The commonest green of the cells that are not `taken`.
bool dominant_green(const std::vector<Cell>& cells, const std::vector<bool>& taken,
                    double least_share, TurfColour& colour) {
  std::array<double, kHueBins> histogram{};
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (taken[i]) continue;
    const double saturation = std::hypot(cells[i].cb, cells[i].cr);
    const double angle = hue(cells[i].cb, cells[i].cr);
    if (saturation < kLeastSaturation || angle < kLeastHue || angle > kMostHue) continue;
    histogram[static_cast<std::size_t>(angle / (2 * kPi) * kHueBins) % kHueBins] += 1;
  }
  std::size_t best = 0;
  double most = 0;
  for (std::size_t i = 0; i < kHueBins; ++i) {
    const double sum = histogram[(i + kHueBins - 1) % kHueBins] + 1.5 * histogram[i] +
                       histogram[(i + 1) % kHueBins];
    if (sum > most) {
      most = sum;
      best = i;
    }
  }
  if (most < least_share * static_cast<double>(cells.size())) return false;
  // Mean hue and median saturation of the cells round the mode.
  const double centre = (static_cast<double>(best) + 0.5) * 2 * kPi / kHueBins;
  double sum = 0;
  std::vector<double> saturations;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Cell& cell = cells[i];
    const double saturation = std::hypot(cell.cb, cell.cr);
    const double angle = hue(cell.cb, cell.cr);
    if (taken[i] || saturation < kLeastSaturation || std::abs(angle - centre) > 10 * kPi / 180)
      continue;
    sum += angle;
    saturations.push_back(saturation);
  }
  if (saturations.empty()) return false;
  colour.hue = sum / static_cast<double>(saturations.size());
  const auto middle = saturations.begin() + static_cast<std::ptrdiff_t>(saturations.size() / 2);
  std::nth_element(saturations.begin(), middle, saturations.end());
  colour.saturation = *middle;
  return true;
}

bool is_turf(double cb, double cr, const TurfColour& turf, double hue_range, double least_share) {
  const double saturation = std::hypot(cb, cr);
  if (saturation < least_share * turf.saturation || saturation > 2.6 * turf.saturation)
    return false;
  return std::abs(hue(cb, cr) - turf.hue) <= hue_range;
}

// Turf in shade is lit by the sky alone, and is of another, bluer and duller green than turf in the
// sun; whichever covers more of the picture is the first colour. What else is green lies farther
// from it, is as bright or brighter for its saturation, or is as uneven as stands are.
bool other_light(const std::vector<Cell>& cells, const std::vector<bool>& first_cells, int columns,
                 const TurfColour& first, TurfColour& other) {
  if (!dominant_green(cells, first_cells, kLeastOtherShare, other)) return false;
  if (std::abs(other.hue - first.hue) > kMostShadeHue) return false;
  std::array<double, 2> luma{};
  std::array<double, 2> count{};
  std::vector<double> steps;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const bool near = std::abs(hue(cells[i].cb, cells[i].cr) - other.hue) < 10 * kPi / 180 &&
                      std::hypot(cells[i].cb, cells[i].cr) > 0.6 * other.saturation;
    if (!first_cells[i] && !near) continue;
    const std::size_t kind = first_cells[i] ? 0 : 1;
    luma[kind] += static_cast<double>(cells[i].y) - kBlack;
    ++count[kind];
    if (kind == 1 && (i + 1) % static_cast<std::size_t>(columns) != 0)
      steps.push_back(std::abs(double{cells[i + 1].y} - double{cells[i].y}));
  }
  if (count[0] < 1 || steps.empty()) return false;
  const double bright = luma[0] / count[0];
  const double other_bright = luma[1] / count[1];
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  if (*middle > kMostUneven * other_bright) return false;
  // The darker of the two is the duller as well.
  const bool darker = other_bright < kDarker * bright && other.saturation < first.saturation;
  const bool brighter = bright < kDarker * other_bright && first.saturation < other.saturation;
  return darker || brighter;
}

using Mask = image::Image<std::uint8_t>;

// Square structuring element of 3 by 3 cells; outside the picture counts as `outside`.
Mask morph(const Mask& in, bool grow) {
  Mask out(in.width(), in.height());
  for (int y = 0; y < in.height(); ++y) {
    for (int x = 0; x < in.width(); ++x) {
      bool any = false;
      bool all = true;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          if (!in.contains(x + dx, y + dy)) continue;
          const bool set = in(x + dx, y + dy) != 0;
          any = any || set;
          all = all && set;
        }
      }
      out(x, y) = (grow ? any : all) ? 1 : 0;
    }
  }
  return out;
}

// Four-connected components of the cells equal to `value`; calls visit(cells, touches_border).
template <typename Visit>
void for_each_component(const Mask& mask, std::uint8_t value, Visit visit) {
  Mask seen(mask.width(), mask.height());
  std::vector<int> stack;
  std::vector<int> cells;
  for (int start = 0; start < mask.width() * mask.height(); ++start) {
    if (mask.data()[start] != value || seen.data()[start] != 0) continue;
    cells.clear();
    stack.assign(1, start);
    seen.data()[start] = 1;
    bool border = false;
    while (!stack.empty()) {
      const int at = stack.back();
      stack.pop_back();
      cells.push_back(at);
      const int x = at % mask.width();
      const int y = at / mask.width();
      border = border || x == 0 || y == 0 || x == mask.width() - 1 || y == mask.height() - 1;
      const std::array<std::array<int, 2>, 4> around{
          {{x - 1, y}, {x + 1, y}, {x, y - 1}, {x, y + 1}}};
      for (const auto& next : around) {
        if (!mask.contains(next[0], next[1])) continue;
        const int index = next[1] * mask.width() + next[0];
        if (mask.data()[index] != value || seen.data()[index] != 0) continue;
        seen.data()[index] = 1;
        stack.push_back(index);
      }
    }
    visit(cells, border);
  }
}

}  // namespace

TurfMask find_turf(const image::Frame& frame, const LineMapOptions& options) {
  const int columns = (frame.width() + kStep - 1) / kStep;
  const int rows = (frame.height() + kStep - 1) / kStep;
  TurfMask result;
  result.cells = Mask(columns, rows);
  const std::vector<Cell> cells = cell_means(frame, columns, rows);
  const double range = options.turf_hue_deg * kPi / 180;
  std::vector<TurfColour> colours(1);
  std::vector<bool> taken(cells.size(), false);
  if (!dominant_green(cells, taken, kLeastShare, colours[0])) return result;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const double saturation = std::hypot(cells[i].cb, cells[i].cr) / colours[0].saturation;
    taken[i] = saturation > kSameLeast && saturation < kSameMost &&
               std::abs(hue(cells[i].cb, cells[i].cr) - colours[0].hue) < kSameHue;
  }
  if (TurfColour other; other_light(cells, taken, columns, colours[0], other))
    colours.push_back(other);
  const auto turf_coloured = [&](double cb, double cr, double hue_range, double least_share) {
    return std::any_of(colours.begin(), colours.end(), [&](const TurfColour& colour) {
      return is_turf(cb, cr, colour, hue_range, least_share);
    });
  };
  Mask mask(columns, rows);
  for (std::size_t i = 0; i < cells.size(); ++i)
    mask.data()[i] =
        turf_coloured(cells[i].cb, cells[i].cr, range, options.turf_saturation) ? 1 : 0;
  // Opened, so that green on hoardings and in the stands does not hang on to the pitch; then closed
  // over lines and people.
  mask = morph(morph(mask, false), true);
  mask = morph(morph(mask, true), false);
  std::size_t largest = 0;
  for_each_component(mask, 1, [&](const std::vector<int>& part, bool) {
    largest = std::max(largest, part.size());
  });
  Mask kept(columns, rows);
  for_each_component(mask, 1, [&](const std::vector<int>& part, bool) {
    if (part.size() * 20 < largest || part.size() * 200 < cells.size()) return;
    for (const int at : part) kept.data()[at] = 1;
  });
  for_each_component(kept, 0, [&](const std::vector<int>& part, bool border) {
    if (border && part.size() * 400 > cells.size()) return;
    if (part.size() * 25 > cells.size()) return;
    for (const int at : part) kept.data()[at] = 1;
  });
  std::size_t count = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) count += kept.data()[i];
  result.share = static_cast<double>(count) / static_cast<double>(cells.size());
  result.cells = std::move(kept);
  result.luma = image::Image<std::uint16_t>(columns, rows);
  for (std::size_t i = 0; i < cells.size(); ++i)
    result.luma.data()[i] = static_cast<std::uint16_t>(cells[i].y);
  for (int cr = 0; cr < 64; ++cr) {
    for (int cb = 0; cb < 64; ++cb) {
      const double b = cb * 16 + 8 - 512;
      const double r = cr * 16 + 8 - 512;
      result.like[static_cast<std::size_t>(cr * 64 + cb)] =
          turf_coloured(b, r, 1.7 * range, 0.4 * options.turf_saturation) ? 1 : 0;
    }
  }
  return result;
}

}  // namespace touchline::calibrate
