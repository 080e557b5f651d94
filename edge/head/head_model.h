// What the encoders of a head mean, learnt from the frames whose lines say where the camera points,
// and then told for frames whose lines do not. Offset, scale and sign of pan and tilt and the map
// of the zoom ring are learnt; slipping encoders are noticed and not believed.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "edge/head/axis_fit.h"
#include "edge/head/count_unwrap.h"
#include "edge/head/head_counts.h"
#include "edge/head/zoom_map.h"
#include "shared/base/result.h"
#include "shared/geometry/mount.h"

namespace touchline::head {

struct HeadModelOptions {
  AxisOptions pan;
  AxisOptions tilt;
  ZoomOptions zoom;

  // kConfiguration, naming field, value and bound.
  base::Status validate() const;
};

struct HeadPrediction {
  geometry::HeadPose pose;                             // in the head's frame
  Eigen::Vector3d variance = Eigen::Vector3d::Zero();  // of pan, tilt (radians squared), log focal
};

class HeadModel {
 public:
  // Options must be valid.
  explicit HeadModel(const HeadModelOptions& options = {});

  // The counts of a frame, in the order of time, whether its lines say something or not.
  void observe(const HeadCounts& counts);
  // Where the camera points in the frame observed last, by its lines.
  void learn(const geometry::HeadPose& pose);
  // The same for the frame observed last, by its counts alone. Pan lies within +-pi.
  std::optional<HeadPrediction> predict() const;
  // Why nothing is predicted; empty otherwise.
  std::string why() const;
  // What was learnt belongs to a mount: with another one it starts anew.
  void forget();

  const AxisFit& pan() const { return pan_; }
  const AxisFit& tilt() const { return tilt_; }
  const ZoomMap& zoom() const { return zoom_; }

 private:
  HeadModelOptions options_;
  CountUnwrap pan_counter_, tilt_counter_, zoom_counter_;
  bool observed_ = false;
  double pan_count_ = 0, tilt_count_ = 0, zoom_count_ = 0;
  AxisFit pan_, tilt_;
  ZoomMap zoom_;
  double roll_ = 0;
  int rolls_ = 0;
};

}  // namespace touchline::head
