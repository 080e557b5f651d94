// A head's encoders beside the calibration of its frames: they are learnt from frames that the
// lines say, start the search where the lines were lost, and are the answer where nothing else is.
#pragma once

#include <optional>
#include <string>

#include "edge/head/head_model.h"
#include "edge/head/head_source.h"
#include "shared/base/result.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/geometry/mount.h"
#include "shared/image/frame.h"

namespace touchline::edge {

struct HeadOptions {
  head::HeadModelOptions model;
  // Encoders alone are believed when the picture they predict is this sure, pixels at 1080 lines;
  // 0.1..100.
  double most_px = 6;
  double roll_sd_deg = 0.02;  // of the roll about its mean; 0..5

  base::Status validate() const;
};

class HeadFollower {
 public:
  // Options must be valid. Without a source it says nothing; else the source must outlive this.
  HeadFollower(head::HeadSource* source, const HeadOptions& options)
      : source_(source), options_(options), model_(options.model) {}

  // The counts of a frame, when it arrives.
  std::optional<head::HeadCounts> read(const image::Frame& frame) {
    return source_ != nullptr ? source_->at(frame.id, frame.stamp) : std::nullopt;
  }
  // The counts of the frame that is calibrated next, in the order of frames.
  void observe(const std::optional<head::HeadCounts>& counts);
  // Of that frame, by its lines.
  void learn(const geometry::Mount& mount, const geometry::CameraEstimate& by_lines);
  // Of that frame, by its counts; evidence kEncoder. As a place to start from; nothing while the
  // encoders are not understood.
  std::optional<geometry::CameraEstimate> prior(const geometry::Mount& mount) const;
  // The same where it is sure enough to stand for the frame.
  std::optional<geometry::CameraEstimate> estimate(const geometry::Mount& mount) const;
  // What was learnt belongs to a mount.
  void forget() { model_.forget(); }
  // When the encoders begin or cease to be understood: for the log; empty otherwise.
  std::string take_note();

 private:
  head::HeadSource* source_;
  HeadOptions options_;
  head::HeadModel model_;
  bool counted_ = false;  // the frame has counts
  bool understood_ = false;
};

}  // namespace touchline::edge
