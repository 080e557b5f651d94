// Exports that tell the truth about the embedded sample, to be scored as they are or spoilt.
#pragma once

#include <functional>
#include <string>

#include "shared/recording/camera_table.h"
#include "shared/recording/recording.h"
#include "tests/support/folders.h"
#include "tools/score/report.h"
#include "tools/score/truth.h"

namespace touchline::score {

class TrueExports {
 public:
  TrueExports();  // opens tests/data/sample

  const recording::Recording& recording() const { return recording_; }
  const Truth& truth() const { return truth_; }
  std::filesystem::path folder() const { return folder_.path(); }

  // Each writes one kind of export; `spoil` changes what is written.
  void write_cameras(
      const std::function<void(const std::string&, recording::CameraRow&)>& spoil = {}) const;
  using SpoilMatte = std::function<void(std::int64_t frame, image::Image<std::uint8_t>& matte)>;
  void write_mattes(const std::string& camera, const SpoilMatte& spoil = {}) const;
  void write_hulls() const;  // carved from the true mattes
  void write_people(const std::function<void(TruePerson&, std::int64_t)>& spoil = {}) const;
  void write_views(int shift_px = 0) const;

  base::Result<ScoreReport> score() const;

 private:
  support::TempFolder folder_;
  recording::Recording recording_;
  Truth truth_;
};

// The series' figure; fails the test where there is none.
double figure(const ScoreReport& report, const std::string& group, const std::string& score,
              const std::string& subject = "all");

}  // namespace touchline::score
