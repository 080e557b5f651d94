// The luma across a marking, and the white ridges of the expected width in it.
#pragma once

#include <vector>

#include "edge/calibrate/lines/line_points.h"
#include "shared/image/frame.h"

namespace touchline::calibrate {

// Measures windows of one frame; holds scratch memory, so one object serves one thread.
class ProfileReader {
 public:
  ProfileReader(const image::Frame& frame, const LinePointOptions& options);

  // Fills state, count and candidates of a window whose geometry is set. False when the picture's
  // edge leaves too little of it.
  bool measure(LinePoint& window);

 private:
  struct Span {
    double low;  // along the normal, pixels
    double high;
  };
  Span inside(const LinePoint& window, double reach) const;
  void sample(const LinePoint& window, double low, int count);
  void shape_template(double width_px);
  double noise() const;
  void correlate();
  // Correlation coefficient of the samples round index `centre` with the template, a linear trend
  // taken out.
  double match(int centre) const;
  // True where what is found at index `centre` for thin paint is a far wider band: ground beside
  // the pitch before a hoarding, a mown stripe seen from the side.
  bool far_wider(int centre) const;
  bool turf_at(const Eigen::Vector2d& pixel) const;
  bool is_turf(double luma, double cb, double cr) const;
  bool paint_on_turf(const LinePoint& window, double offset) const;

  const image::Frame& frame_;
  const LinePointOptions& options_;
  image::ChromaShift shift_;
  double scale_;  // of the options' pixels
  double blur_;

  double step_ = 0.5;  // between samples, pixels
  std::vector<float> samples_;
  std::vector<float>
      response_;  // amplitude of the template at each sample, fitted by least squares
  double template_width_ = -1;
  std::vector<float> weights_;  // amplitude = weights . samples
  std::vector<float> shape_;    // coverage of the paint, mean taken out
  double shape_energy_ = 0;     // sum of shape squared
  double slope_energy_ = 0;     // sum of the squared slope of coverage, per pixel
  int half_ = 0;                // template taps each side
  mutable std::vector<float> scratch_;
};

}  // namespace touchline::calibrate
