// Counts of one encoder -> an angle: offset and scale, robustly, and how sure.
#pragma once

#include <optional>
#include <string>

#include "edge/head/samples.h"

namespace touchline::head {

struct Predicted {
  double value = 0;
  double variance = 0;
};

struct AxisOptions {
  int least_samples = 12;  // measured frames before anything is said; 6..1000
  double most_sd = 0.002;  // counts that scatter more than this about the line disagree; radians
  double floor_sd = 4e-5;  // of measured angles, radians
  // What measured angles of neighbouring views err by together, which no number of them averages
  // out: mount and lens are not known exactly; radians.
  double bias_sd = 3e-4;
  int most_slips = 3;  // an encoder that slips more often is not trusted; 0..1000
};

class AxisFit {
 public:
  explicit AxisFit(const AxisOptions& options = {}) : options_(options) {}

  // `angle` may wrap at +-pi.
  void learn(double count, double angle);
  // The angle is not wrapped. Nothing while too little is known, and while counts disagree.
  std::optional<Predicted> predict(double count) const;
  // Why nothing is predicted; empty otherwise.
  std::string why() const;

  double scale() const { return slope_; }  // radians a count
  double sd() const { return sd_; }        // of the angles about the line, radians
  int slips() const { return slips_; }

 private:
  void fit();
  bool has_slipped() const;

  AxisOptions options_;
  Samples samples_;
  bool fitted_ = false;
  double middle_ = 0;  // count about which the line is given
  double level_ = 0;   // angle there
  double slope_ = 0;
  double slope_variance_ = 0;
  double sd_ = 0;
  double inliers_ = 0;  // share
  int slips_ = 0;
  bool scale_known_ = false;  // from before a slip
  double known_slope_ = 0;
};

}  // namespace touchline::head
