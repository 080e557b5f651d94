// A score over frames: what it is, its samples, and a summary with a 95 % confidence interval.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace touchline::score {

enum class Better : std::uint8_t { kLower, kHigher, kOne };  // kOne: the nearer to 1
// What Summary::mean is made of the samples.
enum class Statistic : std::uint8_t {
  kMean,            // weighted mean
  kRootMeanSquare,  // of signed samples; median and p95 are of their magnitudes
  kTotal,           // sum
};

std::string_view name(Better better);        // "lower", "higher", "one"
std::string_view name(Statistic statistic);  // "mean", "rms", "total"

// The kind of a score, the same for all its subjects.
struct ScoreKind {
  std::string group;  // "cameras", "mattes", "hull", "people", "views"
  std::string score;  // name, unique within its group
  std::string unit;   // "px", "%", "m", "deg", "dB", ""
  Better better = Better::kLower;
  Statistic statistic = Statistic::kMean;
  int decimals = 2;  // in tables
};

struct Sample {
  std::int64_t frame = 0;  // of the recording, or of the virtual camera's table
  double value = 0;
  double weight = 1;  // its part in the mean: the area of a share, the vertices of a person, ...
};

// NaN where there is nothing to take it of; the interval needs two frames.
struct Summary {
  std::size_t n = 0;  // samples
  double mean = 0;    // the figure, by the kind's statistic
  double median = 0;
  double p95 = 0;
  double ci_low = 0;  // 95 % confidence interval of `mean`
  double ci_high = 0;
};

struct Series {
  ScoreKind kind;
  std::string subject;  // a camera, person or view, or "all": every sample of every subject
  bool of_person = false;
  bool pooled = false;  // an "all" made of the other series of this kind
  std::vector<Sample> samples;
  Summary summary;
  // Views only: the same score of our renderer with true cameras and true mattes.
  std::optional<Summary> oracle;
};

// The interval is that of a circular moving-block bootstrap over frames (Kunsch 1989; Politis and
// Romano 1992): frames are correlated, so whole runs of frames are drawn, and all samples of a
// frame go together. The run is ceil((2 r / (1 - r^2))^(2/3) n^(1/3)) frames for n frames whose
// figures have the lag-1 autocorrelation r (Carlstein 1986), at most a third of them; 1000 draws
// with a fixed seed; 2.5 % and 97.5 % quantiles. Of a short clip it tells what these frames say
// about each other, not what another match would show.
Summary summarise(const std::vector<Sample>& samples, Statistic statistic);

// The value below which `share` of the values lie, between neighbours linearly; 0 when there are
// none.
double quantile(std::vector<double> values, double share);

// Collects samples by kind and subject, in the order in which they first come.
class SeriesBook {
 public:
  void add(const ScoreKind& kind, const std::string& subject, const Sample& sample);
  // The same for a score whose subjects are people.
  void add_person(const ScoreKind& kind, const std::string& person, const Sample& sample);
  // The series of one kind and subject; none when nothing was added.
  const Series* find(const std::string& group, const std::string& score,
                     const std::string& subject) const;
  // With summaries; a kind with several subjects gets one more, "all", ahead of them. Kinds that
  // come apart stay together.
  std::vector<Series> finish() const;

 private:
  std::vector<Series> series_;
  std::map<std::pair<std::string, std::string>, std::map<std::string, std::size_t>> index_;
};

}  // namespace touchline::score
