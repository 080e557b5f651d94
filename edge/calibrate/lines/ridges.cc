#include <algorithm>
#include <cmath>

#include "edge/calibrate/lines/ridges_internal.h"

namespace touchline::calibrate {
namespace {

using Luma = image::Image<std::uint16_t>;

constexpr int kTurfStep = LineMap::kTurfStep;

// Rows become columns, in blocks that stay in cache.
Luma transpose(image::ImageView<const std::uint16_t> in) {
  Luma out(in.height, in.width);
  constexpr int kBlock = 32;
  for (int y0 = 0; y0 < in.height; y0 += kBlock) {
    for (int x0 = 0; x0 < in.width; x0 += kBlock) {
      const int y1 = std::min(y0 + kBlock, in.height);
      const int x1 = std::min(x0 + kBlock, in.width);
      for (int x = x0; x < x1; ++x) {
        std::uint16_t* to = out.row(x);
        for (int y = y0; y < y1; ++y) to[y] = in.row(y)[x];
      }
    }
  }
  return out;
}

constexpr double kMostWidthShare = 0.3;  // width over length of a chain
// Least sum of a chain's contrasts, in chains of the least length at the threshold.
constexpr double kLeastEvidence = 4;

// One crossing of a ridge by a scan line.
struct Run {
  float at = 0;  // centre along the scan line
  float contrast = 0;
  float width = 0;
  int next = -1;      // on a later scan line
  int previous = -1;  // on an earlier one
  int line = 0;
};

struct Scales {
  // Distances at which a ridge must stand over both its sides.
  int near = 4;
  int middle = 12;
  int far = 22;
  int longest = 40;  // ridge along the scan line, pixels
};

// How the luma of turf varies over a few pixels: the median of |difference| as a sigma.
double texture_sigma(image::ImageView<const std::uint16_t> luma, const TurfMask& turf) {
  std::vector<int> differences;
  for (int r = 1; r + 1 < turf.cells.height(); r += 2) {
    for (int c = 1; c + 1 < turf.cells.width(); c += 2) {
      if (turf.cells(c, r) == 0) continue;
      const int x = c * kTurfStep;
      const int y = r * kTurfStep;
      if (x + 4 >= luma.width || y >= luma.height) continue;
      differences.push_back(std::abs(int(luma.row(y)[x]) - int(luma.row(y)[x + 4])));
    }
  }
  if (differences.empty()) return 0;
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  return *middle / 0.6745;
}

// Scans the rows of `luma` for ridges that cross them. `flipped` = luma is the transposed picture.
class RowScan {
 public:
  RowScan(const image::Frame& frame, image::ImageView<const std::uint16_t> luma,
          const TurfMask& turf, bool flipped, int threshold, const Scales& scales)
      : frame_(frame),
        luma_(luma),
        turf_(turf),
        flipped_(flipped),
        threshold_(threshold),
        scales_(scales),
        shift_(image::chroma_shift(frame.format)) {}

  void scan() {
    const int n = luma_.width;
    response_.resize(static_cast<std::size_t>(n));
    first_.assign(static_cast<std::size_t>(luma_.height) + 1, 0);
    for (int y = 0; y < luma_.height; ++y) {
      first_[static_cast<std::size_t>(y)] = static_cast<int>(runs_.size());
      if (y > 0 && y + 1 < luma_.height) scan_row(y);
    }
    first_.back() = static_cast<int>(runs_.size());
  }

  // Links runs on successive scan lines into chains.
  void link() {
    struct Tip {
      int run;
      float slope;
      int length;
    };
    std::vector<Tip> tips;
    std::vector<Tip> alive;
    for (int y = 0; y < luma_.height; ++y) {
      const int begin = first_[static_cast<std::size_t>(y)];
      const int end = first_[static_cast<std::size_t>(y) + 1];
      alive.clear();
      for (const Tip& tip : tips)
        if (y - runs_[static_cast<std::size_t>(tip.run)].line <= 3) alive.push_back(tip);
      tips.swap(alive);
      for (int i = begin; i < end; ++i) {
        Run& run = runs_[static_cast<std::size_t>(i)];
        Tip* best = nullptr;
        float nearest = 1e9F;
        for (Tip& tip : tips) {
          const Run& last = runs_[static_cast<std::size_t>(tip.run)];
          if (last.line == y || last.next >= 0) continue;
          const float gap = static_cast<float>(y - last.line);
          const float miss = std::abs(run.at - (last.at + tip.slope * gap));
          const float allowed = tip.length < 4 ? 1.5F * gap : 0.9F + 0.35F * gap;
          if (miss < allowed && miss < nearest) {
            nearest = miss;
            best = &tip;
          }
        }
        if (best != nullptr) {
          Run& last = runs_[static_cast<std::size_t>(best->run)];
          const float gap = static_cast<float>(y - last.line);
          const float slope = (run.at - last.at) / gap;
          last.next = i;
          run.previous = best->run;
          const float keep = best->length < 2 ? 0.0F : (best->length < 6 ? 0.6F : 0.85F);
          best->slope = keep * best->slope + (1 - keep) * slope;
          best->run = i;
          ++best->length;
        } else {
          tips.push_back({i, 0.0F, 1});
        }
      }
    }
  }

  // Points of chains that are long and smooth enough.
  void collect(int least_length, int& chain_count, std::vector<RidgePoint>& points) const {
    std::vector<int> chain;
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      if (runs_[i].previous >= 0) continue;
      chain.clear();
      for (int at = static_cast<int>(i); at >= 0; at = runs_[static_cast<std::size_t>(at)].next)
        chain.push_back(at);
      if (static_cast<int>(chain.size()) < least_length) continue;
      add_chain(chain, least_length, chain_count, points);
    }
  }

 private:
  void scan_row(int y) {
    const int n = luma_.width;
    const std::uint16_t* above = luma_.row(y - 1);
    const std::uint16_t* here = luma_.row(y);
    const std::uint16_t* below = luma_.row(y + 1);
    // The smoothed row goes on beyond the picture with its last value.
    const int margin = scales_.far + 4;
    smooth_.resize(static_cast<std::size_t>(n + 2 * margin));
    int* smooth = smooth_.data() + margin;
    int* response = response_.data();
    const int cells = flipped_ ? turf_.cells.height() : turf_.cells.width();
    const int across = y / kTurfStep;
    int cell = 0;
    while (cell < cells) {
      while (cell < cells && !cell_is_turf(cell, across)) ++cell;
      const int from_cell = cell;
      while (cell < cells && cell_is_turf(cell, across)) ++cell;
      if (from_cell == cell) break;
      const int from = from_cell * kTurfStep;
      const int to = std::min(cell * kTurfStep, n);
      const int first = std::max(from - margin, 0);
      const int last = std::min(to + margin, n);
      for (int x = first; x < last; ++x)
        smooth[x] = int(above[x]) + 2 * int(here[x]) + int(below[x]);
      for (int x = from - margin; x < first; ++x) smooth[x] = smooth[first];
      for (int x = last; x < to + margin; ++x) smooth[x] = smooth[last - 1];
      const int near = scales_.near;
      const int middle = scales_.middle;
      const int far = scales_.far;
      for (int x = from; x < to; ++x) {
        const int v = smooth[x];
        const int a = std::min(v - smooth[x - near], v - smooth[x + near]);
        const int b = std::min(v - smooth[x - middle], v - smooth[x + middle]);
        const int c = std::min(v - smooth[x - far], v - smooth[x + far]);
        response[x] = std::max(a, std::max(b, c));
      }
      take_runs(y, from, to);
    }
  }

  bool cell_is_turf(int along, int across) const {
    return (flipped_ ? turf_.cells(across, along) : turf_.cells(along, across)) != 0;
  }

  void take_runs(int y, int from, int to) {
    const int high = 4 * threshold_;
    const int low = 2 * threshold_;
    const int* response = response_.data();
    int x = from;
    while (x < to) {
      if (response[x] <= high) {
        ++x;
        continue;
      }
      int begin = x;
      while (begin > from && response[begin - 1] > low) --begin;
      int end = x;
      while (end < to && response[end] > low) ++end;
      if (end - begin <= scales_.longest) add_run(y, begin, end, from, to);
      x = end + 1;
    }
  }

  // A ridge whose response is above the threshold in [begin, end) of the turf in [from, to).
  void add_run(int y, int begin, int end, int from, int to) {
    const int* smooth = smooth_.data() + scales_.far + 4;
    int top = begin;
    for (int x = begin; x < end; ++x)
      if (smooth[x] > smooth[top]) top = x;
    // Down the flanks to half way between the top and the turf beside it.
    const int half = smooth[top] - response_[static_cast<std::size_t>(top)] / 2;
    int left = top;
    while (left > from && smooth[left] > half && top - left <= scales_.longest) --left;
    int right = top;
    while (right + 1 < to && smooth[right] > half && right - top <= scales_.longest) ++right;
    if (right - left > scales_.longest) return;
    // On to the feet of the flanks, at most three pixels.
    for (int i = 0; i < 3 && left > from && smooth[left - 1] < smooth[left]; ++i) --left;
    for (int i = 0; i < 3 && right + 1 < to && smooth[right + 1] < smooth[right]; ++i) ++right;
    if (left <= from || right + 1 >= to) return;
    const double base_left = smooth[left];
    const double base_right = smooth[right];
    double sum = 0, moment = 0, most = 0;
    for (int x = left; x <= right; ++x) {
      const double t = static_cast<double>(x - left) / (right - left);
      const double over = smooth[x] - ((1 - t) * base_left + t * base_right);
      if (over <= 0) continue;
      sum += over;
      moment += over * x;
      most = std::max(most, over);
    }
    if (most < 2 * threshold_) return;
    const double at = moment / sum;
    // Turf on both sides: hoardings, posts before the stands and kit have something else on one.
    if (!turf_like(left - 2, y) || !turf_like(right + 2, y)) return;
    Run run;
    run.at = static_cast<float>(at);
    run.contrast = static_cast<float>(most / 4);
    run.width = static_cast<float>(sum / most);
    run.line = y;
    runs_.push_back(run);
  }

  bool turf_like(int along, int across) const {
    int x = flipped_ ? across : along;
    int y = flipped_ ? along : across;
    x = std::clamp(x, 0, frame_.width() - 1) >> shift_.x;
    y = std::clamp(y, 0, frame_.height() - 1) >> shift_.y;
    const int cb = std::min<int>(frame_.planes[1].row(y)[x] >> 4, 63);
    const int cr = std::min<int>(frame_.planes[2].row(y)[x] >> 4, 63);
    return turf_.like[static_cast<std::size_t>(cr * 64 + cb)] != 0;
  }

  void add_chain(const std::vector<int>& chain, int least_length, int& chain_count,
                 std::vector<RidgePoint>& points) const {
    // A local straight line through each point and its neighbours gives the direction; points that
    // jump about are not on a line.
    constexpr int kHalf = 7;
    const int n = static_cast<int>(chain.size());
    std::vector<RidgePoint> kept;
    kept.reserve(chain.size());
    for (int i = 0; i < n; ++i) {
      const int from = std::max(0, i - kHalf);
      const int to = std::min(n - 1, i + kHalf);
      double st = 0, sx = 0, stt = 0, stx = 0, sxx = 0;
      const Run& centre = runs_[static_cast<std::size_t>(chain[static_cast<std::size_t>(i)])];
      for (int k = from; k <= to; ++k) {
        const Run& run = runs_[static_cast<std::size_t>(chain[static_cast<std::size_t>(k)])];
        const double t = run.line - centre.line;
        const double x = run.at - centre.at;
        st += t;
        sx += x;
        stt += t * t;
        stx += t * x;
        sxx += x * x;
      }
      const double count = to - from + 1;
      const double det = count * stt - st * st;
      if (det <= 0) continue;
      const double slope = (count * stx - st * sx) / det;
      const double intercept = (sx - slope * st) / count;
      const double residual = std::max(0.0, (sxx - intercept * sx - slope * stx) / count);
      if (std::abs(slope) > 1.12 || residual > 0.36 || std::abs(intercept) > 1.0) continue;
      RidgePoint point;
      const float norm = static_cast<float>(1 / std::sqrt(1 + slope * slope));
      const float s = static_cast<float>(slope);
      const float along = centre.at;
      const float across = static_cast<float>(centre.line);
      if (flipped_) {
        point.position = {across, along};
        point.normal = {-s * norm, norm};
      } else {
        point.position = {along, across};
        point.normal = {norm, -s * norm};
      }
      point.contrast = centre.contrast;
      point.width = centre.width * norm;
      point.chain = chain_count;
      kept.push_back(point);
    }
    if (static_cast<int>(kept.size()) < least_length ||
        static_cast<double>(kept.size()) < 0.6 * static_cast<double>(chain.size()))
      return;
    // A chain that hardly stands out of the turf must be the longer.
    double contrast = 0;
    double width = 0;
    for (const RidgePoint& point : kept) {
      contrast += point.contrast;
      width += point.width;
    }
    if (contrast < kLeastEvidence * least_length * threshold_) return;
    // One that is hardly longer than wide is a sock, a shirt or a ball.
    if (width > kMostWidthShare * static_cast<double>(kept.size() * kept.size())) return;
    points.insert(points.end(), kept.begin(), kept.end());
    ++chain_count;
  }

  const image::Frame& frame_;
  image::ImageView<const std::uint16_t> luma_;
  const TurfMask& turf_;
  bool flipped_;
  int threshold_;
  Scales scales_;
  image::ChromaShift shift_;
  std::vector<int> smooth_;    // luma times 4, smoothed along the other axis
  std::vector<int> response_;  // of the ridge, times 4
  std::vector<int> first_;     // run at which each scan line begins
  std::vector<Run> runs_;
};

// Nets and texture show as many ridges in little room: blocks with more points than a few lines
// can have are left out.
void drop_crowds(int width, int height, std::vector<RidgePoint>& points) {
  const double scale = std::max(height / 1080.0, 0.5);
  const int block = std::max(16, static_cast<int>(std::lround(64 * scale)));
  const int most = 5 * block;
  const int columns = width / block + 1;
  const int rows = height / block + 1;
  image::Image<int> count(columns, rows, 0);
  const auto cell = [&](const RidgePoint& point) -> int& {
    return count(std::clamp(static_cast<int>(point.position.x()) / block, 0, columns - 1),
                 std::clamp(static_cast<int>(point.position.y()) / block, 0, rows - 1));
  };
  for (const RidgePoint& point : points) ++cell(point);
  std::erase_if(points, [&](const RidgePoint& point) { return cell(point) > most; });
}

}  // namespace

std::vector<RidgePoint> find_ridges(const image::Frame& frame, const TurfMask& turf,
                                    const LineMapOptions& options, double& least_contrast) {
  const double scale = frame.height() / 1080.0;
  Scales scales;
  scales.near = std::max(2, static_cast<int>(std::lround(4 * scale)));
  scales.middle = std::max(4, static_cast<int>(std::lround(12 * scale)));
  scales.far = std::max(8, static_cast<int>(std::lround(22 * scale)));
  scales.longest = std::max(12, static_cast<int>(std::lround(40 * scale)));
  const int least = std::max(8, static_cast<int>(std::lround(options.least_chain_px * scale)));
  const double sigma = texture_sigma(frame.luma(), turf);
  const int threshold = static_cast<int>(
      std::lround(std::max(options.least_contrast, options.noise_factor * sigma * 0.7)));
  least_contrast = threshold;

  std::vector<RidgePoint> points;
  int chains = 0;
  RowScan rows(frame, frame.luma(), turf, false, threshold, scales);
  rows.scan();
  rows.link();
  rows.collect(least, chains, points);
  const Luma turned = transpose(frame.luma());
  RowScan columns(frame, turned.view(), turf, true, threshold, scales);
  columns.scan();
  columns.link();
  columns.collect(least, chains, points);
  drop_crowds(frame.width(), frame.height(), points);
  return points;
}

}  // namespace touchline::calibrate
