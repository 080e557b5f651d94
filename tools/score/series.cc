#include "tools/score/series.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace touchline::score {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr int kDraws = 1000;
constexpr std::uint64_t kSeed = 20261122;

// Sums of one frame, or of a draw of frames.
struct Sums {
  double values = 0;  // weighted, squared for root mean squares
  double weights = 0;

  void add(const Sums& other) {
    values += other.values;
    weights += other.weights;
  }
  double figure(Statistic statistic) const {
    if (statistic == Statistic::kTotal) return values;
    if (weights <= 0) return kNone;
    const double mean = values / weights;
    return statistic == Statistic::kRootMeanSquare ? std::sqrt(mean) : mean;
  }
};

std::vector<Sums> by_frame(const std::vector<Sample>& samples, Statistic statistic) {
  std::map<std::int64_t, Sums> frames;
  for (const Sample& sample : samples) {
    const double value =
        statistic == Statistic::kRootMeanSquare ? sample.value * sample.value : sample.value;
    const double weight = statistic == Statistic::kTotal ? 1 : sample.weight;
    frames[sample.frame].add({value * weight, weight});
  }
  std::vector<Sums> sums;
  for (const auto& [frame, sum] : frames) sums.push_back(sum);
  return sums;
}

// Frames that are drawn in one run.
std::size_t block_length(const std::vector<Sums>& frames) {
  const std::size_t n = frames.size();
  if (n < 6) return 1;
  std::vector<double> figures;
  for (const Sums& frame : frames) {
    figures.push_back(frame.weights > 0 ? frame.values / frame.weights : 0);
  }
  double mean = 0;
  for (const double value : figures) mean += value / static_cast<double>(n);
  double variance = 0;
  double lagged = 0;
  for (std::size_t i = 0; i < n; ++i) {
    variance += (figures[i] - mean) * (figures[i] - mean);
    if (i > 0) lagged += (figures[i] - mean) * (figures[i - 1] - mean);
  }
  const double r = variance > 0 ? std::clamp(lagged / variance, 0.0, 0.97) : 0;
  const double length = std::cbrt(static_cast<double>(n)) * std::pow(2 * r / (1 - r * r), 2.0 / 3);
  return std::clamp<std::size_t>(static_cast<std::size_t>(std::ceil(length)), 1, n / 3);
}

double quantile_of(const std::vector<Sample>& samples, bool magnitudes, double share) {
  std::vector<double> values;
  for (const Sample& sample : samples) {
    if (sample.weight > 0) values.push_back(magnitudes ? std::abs(sample.value) : sample.value);
  }
  return values.empty() ? kNone : quantile(std::move(values), share);
}

}  // namespace

std::string_view name(Better better) {
  switch (better) {
    case Better::kLower:
      return "lower";
    case Better::kHigher:
      return "higher";
    case Better::kOne:
      break;
  }
  return "one";
}

std::string_view name(Statistic statistic) {
  switch (statistic) {
    case Statistic::kMean:
      return "mean";
    case Statistic::kRootMeanSquare:
      return "rms";
    case Statistic::kTotal:
      break;
  }
  return "total";
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const double at = share * static_cast<double>(values.size() - 1);
  const auto low = static_cast<std::size_t>(at);
  const std::size_t high = std::min(low + 1, values.size() - 1);
  const double part = at - static_cast<double>(low);
  return values[low] * (1 - part) + values[high] * part;
}

Summary summarise(const std::vector<Sample>& samples, Statistic statistic) {
  Summary summary{samples.size(), kNone, kNone, kNone, kNone, kNone};
  if (samples.empty()) return summary;
  const std::vector<Sums> frames = by_frame(samples, statistic);
  Sums all;
  for (const Sums& frame : frames) all.add(frame);
  summary.mean = all.figure(statistic);
  const bool magnitudes = statistic == Statistic::kRootMeanSquare;
  summary.median = quantile_of(samples, magnitudes, 0.5);
  summary.p95 = quantile_of(samples, magnitudes, 0.95);
  const std::size_t n = frames.size();
  if (n < 2 || std::isnan(summary.mean)) return summary;
  const std::size_t block = block_length(frames);
  std::mt19937_64 random(kSeed);
  std::vector<double> figures;
  for (int draw = 0; draw < kDraws; ++draw) {
    Sums sums;
    for (std::size_t drawn = 0; drawn < n;) {
      const auto start = static_cast<std::size_t>(random() % n);
      for (std::size_t i = 0; i < block && drawn < n; ++i, ++drawn) {
        sums.add(frames[(start + i) % n]);
      }
    }
    const double figure = sums.figure(statistic);
    if (!std::isnan(figure)) figures.push_back(figure);
  }
  if (figures.empty()) return summary;
  summary.ci_low = quantile(figures, 0.025);
  summary.ci_high = quantile(std::move(figures), 0.975);
  return summary;
}

void SeriesBook::add(const ScoreKind& kind, const std::string& subject, const Sample& sample) {
  auto& subjects = index_[{kind.group, kind.score}];
  const auto [at, fresh] = subjects.try_emplace(subject, series_.size());
  if (fresh) series_.push_back({kind, subject, false, false, {}, {}, std::nullopt});
  series_[at->second].samples.push_back(sample);
}

void SeriesBook::add_person(const ScoreKind& kind, const std::string& person,
                            const Sample& sample) {
  add(kind, person, sample);
  series_[index_[{kind.group, kind.score}][person]].of_person = true;
}

const Series* SeriesBook::find(const std::string& group, const std::string& score,
                               const std::string& subject) const {
  const auto kind = index_.find({group, score});
  if (kind == index_.end()) return nullptr;
  const auto at = kind->second.find(subject);
  return at == kind->second.end() ? nullptr : &series_[at->second];
}

std::vector<Series> SeriesBook::finish() const {
  std::vector<Series> out;
  std::vector<bool> done(series_.size(), false);
  for (std::size_t i = 0; i < series_.size(); ++i) {
    if (done[i]) continue;
    std::vector<Series> of_kind;
    Series all{series_[i].kind, "all", series_[i].of_person, true, {}, {}, std::nullopt};
    for (std::size_t k = i; k < series_.size(); ++k) {
      if (series_[k].kind.group != all.kind.group || series_[k].kind.score != all.kind.score) {
        continue;
      }
      done[k] = true;
      all.samples.insert(all.samples.end(), series_[k].samples.begin(), series_[k].samples.end());
      of_kind.push_back(series_[k]);
    }
    if (of_kind.size() > 1) of_kind.insert(of_kind.begin(), std::move(all));
    for (Series& series : of_kind) {
      series.summary = summarise(series.samples, series.kind.statistic);
      out.push_back(std::move(series));
    }
  }
  return out;
}

}  // namespace touchline::score
