// The plate of a camera from one run of its unit to the next: read from a file where there is one
// that fits, and written to one now and then and at the end.
#pragma once

#include <cstdint>
#include <filesystem>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "edge/plate/plate_builder.h"
#include "shared/base/ids.h"
#include "shared/base/result.h"
#include "shared/codec/plate_file.h"
#include "shared/runtime/executor.h"

namespace touchline::edge {

struct PlateKeepOptions {
  std::filesystem::path load;  // the plate of an earlier run; need not be there; empty: none
  std::filesystem::path save;  // where this run's goes; empty: nowhere
  int save_frames = 3000;      // frames between two times that it is written; 25..1000000
  // A plate is taken from a mount this far away at most, metres (0..10), and when its pixels are at
  // most this many times finer or coarser than the camera's finest (1..10).
  double most_moved_m = 0.25;
  double most_scale = 1.5;

  base::Status validate() const;
};

// What a frame's camera must be for a saved plate to fit it.
struct PlatePlace {
  Eigen::Vector3d centre_in_world = Eigen::Vector3d::Zero();
  double focal_px = 0;  // the longest that is known
  int width = 0;        // of its pictures
  int height = 0;
  image::Colour colour;
};

class PlateKeeper {
 public:
  // Options must be valid; the executor must outlive this.
  PlateKeeper(base::CameraId camera, PlateKeepOptions options, runtime::Executor& executor);
  ~PlateKeeper();

  // A plate for the camera: the first that is asked for goes on from the file, if it fits. What was
  // saved and does not fit, or is damaged, is a note.
  std::unique_ptr<plate::PlateBuilder> start(const pitch::PitchModel& pitch,
                                             const PlatePlace& place, plate::PlateOptions options);
  // A frame was learnt from. Writes the plate now and then, on the executor.
  void after_frame(plate::PlateBuilder& plate);
  // Writes the plate here and now, after what the executor still writes. Nothing without a file to
  // write to, or a plate worth it.
  base::Status save(plate::PlateBuilder* plate);

  // For the log and the unit's status, in order, since the last call.
  std::vector<std::string> take_notes();

 private:
  std::optional<codec::SavedPlate> read(const PlatePlace& place,
                                        const plate::PlateOptions& options);
  codec::SavedPlate to_save(plate::PlateBuilder& plate) const;
  void wait();

  base::CameraId camera_;
  PlateKeepOptions options_;
  runtime::Executor& executor_;
  PlatePlace place_;
  std::uint64_t frames_before_ = 0;
  int frames_since_save_ = 0;
  bool asked_ = false;         // for the file
  bool judged_ = true;         // what was resumed shows what the camera sees, or not
  bool write_failed_ = false;  // the last time
  std::future<base::Status> writing_;
  std::vector<std::string> notes_;
};

}  // namespace touchline::edge
