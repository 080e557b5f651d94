// Counts of the zoom encoder -> log focal length: rising or falling, but by no formula, since the
// ring of a zoom lens is no measure of focal length.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "edge/head/axis_fit.h"
#include "edge/head/samples.h"

namespace touchline::head {

struct ZoomOptions {
  int least_samples = 12;  // measured frames before anything is said; 6..1000
  double most_sd = 0.01;   // of log focal length about the map; counts that scatter more disagree
  double floor_sd = 5e-4;  // of measured log focal lengths
  double slope = 0.003;    // log focal length a count where the map is not known; 1e-6..1
  int most_slips = 3;      // 0..1000
};

class ZoomMap {
 public:
  explicit ZoomMap(const ZoomOptions& options = {}) : options_(options) {}

  void learn(double count, double log_focal);
  // The monotone map interpolated, and going on as it ends; its variance grows away from what was
  // seen.
  std::optional<Predicted> predict(double count) const;
  std::string why() const;

  double sd() const { return sd_; }

 private:
  // Slope of the map near an end, and how far into the map it was taken.
  struct End {
    double slope = 0;
    double reach = 0;  // counts; 0 where too few are known
  };
  void fit();
  double at(double count) const;
  End end(bool high) const;

  ZoomOptions options_;
  Samples samples_;
  bool fitted_ = false;
  std::vector<Sample> map_;  // by rising count, monotone in value; distinct counts
  double sd_ = 0;
  int slips_ = 0;
};

}  // namespace touchline::head
