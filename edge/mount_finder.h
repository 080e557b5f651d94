// Where a camera stands and how large the pitch is, as far as one camera can know: from its survey
// stills, from the frames of the hold-back, and from the views of a running take, which is surveyed
// again as more of it is seen. Work of more than a frame's time runs on an executor and is adopted
// at a frame boundary: at once with an InlineExecutor, so that a replay gives the same bytes every
// time; some frames later with a BackgroundExecutor, so that a live unit is not held up.
#pragma once

#include <cstdint>
#include <deque>
#include <future>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "edge/calibrate/calibrator.h"
#include "edge/calibrate/closeup_survey.h"
#include "edge/calibrate/survey/survey.h"
#include "edge/calibrate/survey/take_survey.h"
#include "edge/calibrate/take_search.h"
#include "edge/chain_setup.h"
#include "edge/stage_time.h"
#include "shared/base/result.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/geometry/mount.h"
#include "shared/image/frame.h"
#include "shared/pitch/pitch_model.h"
#include "shared/runtime/executor.h"

namespace touchline::edge {

struct MountOptions {
  double retry_s = 2;    // a camera that could not be solved is tried again; 0.1..3600
  int fixed_frames = 6;  // of the hold-back, how many a fixed camera is solved from; 1..64
  // A close-up that could not be solved is tried again from its newest frames: over how long, and
  // how much memory they may take, MiB. The pause before it doubles with every attempt.
  double stretch_s = 2;             // 0.2..10
  int stretch_mib = 560;            // 16..65536
  double most_stretch_wait_s = 30;  // 0.1..3600
  calibrate::SurveyOptions survey;
  calibrate::TakeSurveyOptions take;  // its survey options are those above
  calibrate::CalibrateOptions calibrate;
  calibrate::CloseupSurveyOptions
      closeup;                          // its survey, take and calibrate options are those above
  calibrate::TakeSearchOptions search;  // its take and calibrate options are those above

  base::Status validate() const;
};

// What a survey may take as measured, by what the installer stated.
calibrate::SurveyOptions survey_options(const ChainSetup& setup, calibrate::SurveyOptions options);

class MountFinder {
 public:
  enum class Change : std::uint8_t {
    kNone,
    kSizes,  // the pitch's: following starts anew
    kMount,  // and what was learnt round the old one's centre is void
  };

  // Options must be valid. The executor must outlive this.
  MountFinder(const ChainSetup& setup, const MountOptions& options, pitch::PitchModel pitch,
              runtime::Executor& executor);

  // Nothing until a survey succeeded.
  const std::optional<geometry::Mount>& mount() const { return mount_; }
  const pitch::PitchModel& pitch() const { return pitch_; }
  // Follows frames from the next one on; nothing without a mount. For a close-up that was found
  // late, one that remembers what the frames it was found in look like.
  std::unique_ptr<calibrate::Calibrator> make_calibrator();

  // Compensated survey stills of a head. The cameras of those that were solved, in their order;
  // empty when the survey failed, and then frames are not surveyed either.
  std::vector<geometry::CameraEstimate> from_stills(std::span<const image::Frame> stills);
  // Compensated pictures spread over a recorded take that is looked through before it is played, of
  // a head without survey stills. True when the mount was found in them.
  bool from_take(std::span<const image::FramePtr> pictures);
  // The compensated frames of the hold-back, from the first. Does nothing once the mount is known,
  // nor after from_stills. A close-up's may be found some frames later.
  void from_held(std::span<const image::FramePtr> held);
  // A running frame before it is calibrated: a camera that showed no pitch at first (a cap, a test
  // card) is tried again now and then.
  Change retry(const image::FramePtr& frame);
  // A running frame as it was calibrated. A better mount is adopted when the one in use fits the
  // lines worse, or does not let them be followed.
  Change follow(const image::FramePtr& frame, const geometry::CameraEstimate& estimate);

  double rms_px() const { return rms_px_; }
  int solved() const { return solved_; }
  const StageTime& time() const { return time_; }
  // The camera could not be surveyed although its kind promises that it can.
  const std::optional<base::Error>& error() const { return error_; }
  // For the log and the unit's status, in order, since the last call.
  std::vector<std::string> take_notes();

 private:
  // What a picture or a few say of the mount before anything is known.
  struct FirstMount {
    base::Result<calibrate::SurveyResult> result;
    std::size_t solved = 0;  // the picture
  };
  // What comes back from the executor.
  struct Found {
    std::optional<FirstMount> first;
    std::optional<base::Result<calibrate::CloseupSurvey>> closeup;
    std::unique_ptr<calibrate::Calibrator>
        follower;                               // has seen the frames the close-up was found in
    std::optional<calibrate::TakeSurvey> take;  // which was lent to the work
    std::optional<calibrate::TakeSurveyResult> joint;
    std::optional<geometry::CameraEstimate> resized;
    StageTime time;
  };

  static FirstMount first_mount(const ChainSetup& setup, const MountOptions& options,
                                const pitch::PitchModel& pitch,
                                std::span<const image::FramePtr> shown);
  template <typename Work>
  void start(Work work);
  std::optional<Found> arrived();
  void adopt_sizes(const calibrate::SurveyResult& result);
  void adopt(const calibrate::SurveyResult& result);
  void adopt(const calibrate::TakeSurveyResult& result);
  void adopt_first(FirstMount first);
  void survey_stretch(std::vector<image::FramePtr> frames);
  void adopt(calibrate::CloseupSurvey survey);
  Change retry_closeup(const image::FramePtr& frame);
  void follow_held(std::span<const image::FramePtr> held);
  void look_for_sizes(const image::FramePtr& frame);
  void note(std::string text) { notes_.push_back(std::move(text)); }
  void note_take(const calibrate::TakeSurveyResult& result);

  ChainSetup setup_;
  MountOptions options_;
  pitch::PitchModel pitch_;
  runtime::Executor& executor_;
  std::optional<geometry::Mount> mount_;
  std::optional<geometry::CameraEstimate> initial_;    // of the next frame, where it is known
  std::optional<calibrate::TakeSurvey> take_;          // of a head without survey stills
  std::optional<calibrate::TakeSurveyResult> better_;  // found while running, not adopted yet
  std::future<Found> work_;
  std::unique_ptr<calibrate::Calibrator> follower_;  // the next calibrator, where there is one
  std::deque<image::FramePtr> stretch_;              // the newest frames of an unsolved close-up
  double stretch_wait_s_ = 0;                        // before the next attempt
  int sizes_wait_ = 1;                               // frames, after the next look for them
  int frames_until_sizes_ = 0;  // of lost frames, until the pitch's sizes are looked for again
  bool stills_failed_ = false;
  std::uint64_t frames_since_survey_ = 0;
  double rms_px_ = 0;
  int solved_ = 0;
  StageTime time_{"survey", 0, 0};
  std::optional<base::Error> error_;
  std::vector<std::string> notes_;
};

}  // namespace touchline::edge
