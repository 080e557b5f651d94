#include "edge/mount_finder.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <utility>

#include "edge/chain_internal.h"
#include "shared/base/bounds.h"

namespace touchline::edge {
namespace {

constexpr int kTakePictures = 3;  // held frames that are tried for a head's first mount
// What one picture may say of the sizes against the usual ones, and of a crown; metres.
constexpr double kLengthOff = 12;
constexpr double kWidthOff = 7;
constexpr double kMostCrown = 0.6;
constexpr double kAnySize = 100;  // metres: a size that is not held against the lines
constexpr double kMostSizesWait_s = 60;
constexpr double kStretchHz = 25;      // frames a second that a close-up is found from
constexpr int kTakePasses = 4;         // over the held frames, for the survey of a take
constexpr double kTakeMisfitPx = 0.3;  // rms of a mount's lines at 1080 lines, to look for a better
constexpr double kTakeMisfit = 1.3;    // and so much more than the better one's

// The first mount of a head from one picture, the usual sizes of a pitch first: one picture tells
// little of them. Then with those that nobody measured free, if they come out like a pitch's.
base::Result<calibrate::SurveyResult> survey_head(const ChainSetup& setup,
                                                  const calibrate::SurveyOptions& options,
                                                  const pitch::PitchModel& pitch,
                                                  std::span<const image::FramePtr> shown,
                                                  std::size_t& solved) {
  calibrate::SurveyOptions usual = options;
  const std::array<std::pair<bool*, bool>, 3> sizes{
      {{&usual.length_stated, setup.sizes.length_m.has_value()},
       {&usual.width_stated, setup.sizes.width_m.has_value()},
       {&usual.crown_stated, setup.sizes.crown_m.has_value()}}};
  for (const auto& [stated, measured] : sizes) {
    if (!measured) usual.size_tolerance_m = kAnySize;
    *stated = true;
  }
  base::Result<calibrate::SurveyResult> result = base::fail(base::Error{});
  const std::array<const calibrate::SurveyOptions*, 2> tries{&usual, &options};
  for (const calibrate::SurveyOptions* tried : tries) {
    for (const std::size_t i : spread(shown.size(), kTakePictures)) {
      const std::vector<image::Frame> picture{*shown[i]};
      auto found = calibrate::survey_fixed(picture, pitch, setup.side, *tried);
      if (found &&
          (std::abs(found->length_m - pitch.length_m) > kLengthOff ||
           std::abs(found->width_m - pitch.width_m) > kWidthOff || found->crown_m > kMostCrown)) {
        found = base::fail(
            base::ErrorKind::kNumerical, "survey",
            fmt::format("the lines of a picture fit a pitch of {:.1f} x {:.1f} m with a crown of "
                        "{:.2f} m, which is none",
                        found->length_m, found->width_m, found->crown_m),
            "state the pitch's sizes, or survey stills that show more lines");
      }
      if (found || !result) result = std::move(found);
      solved = i;
      if (result) return result;
    }
  }
  return result;
}

std::unique_ptr<calibrate::Calibrator> calibrator_of(
    const ChainSetup& setup, calibrate::CalibrateOptions options, const pitch::PitchModel& pitch,
    const geometry::Mount& mount, const std::optional<geometry::CameraEstimate>& initial) {
  options.fixed = setup.kind == HeadKind::kFixed;
  auto calibrator = std::make_unique<calibrate::Calibrator>(pitch, mount, options);
  if (initial) calibrator->start_from(*initial);
  return calibrator;
}

}  // namespace

base::Status MountOptions::validate() const {
  if (!(retry_s >= 0.1 && retry_s <= 3600))
    return base::out_of_bounds("retry_s", retry_s, "in 0.1..3600");
  if (fixed_frames < 1 || fixed_frames > 64)
    return base::out_of_bounds("fixed_frames", fixed_frames, "in 1..64");
  if (!(stretch_s >= 0.2 && stretch_s <= 10))
    return base::out_of_bounds("stretch_s", stretch_s, "in 0.2..10");
  if (stretch_mib < 16 || stretch_mib > 65536)
    return base::out_of_bounds("stretch_mib", stretch_mib, "in 16..65536");
  if (!(most_stretch_wait_s >= 0.1 && most_stretch_wait_s <= 3600))
    return base::out_of_bounds("most_stretch_wait_s", most_stretch_wait_s, "in 0.1..3600");
  for (const base::Status& part : {survey.validate(), take.validate(), calibrate.validate(),
                                   closeup.validate(), search.validate()}) {
    if (!part) return part;
  }
  return {};
}

calibrate::SurveyOptions survey_options(const ChainSetup& setup, calibrate::SurveyOptions options) {
  options.length_stated = setup.sizes.length_m.has_value();
  options.width_stated = setup.sizes.width_m.has_value();
  options.crown_stated = setup.sizes.crown_m.has_value();
  return options;
}

MountFinder::MountFinder(const ChainSetup& setup, const MountOptions& options,
                         pitch::PitchModel pitch, runtime::Executor& executor)
    : setup_(setup), options_(options), pitch_(std::move(pitch)), executor_(executor) {
  options_.survey = survey_options(setup, options.survey);
  options_.take.survey = options_.survey;
  options_.closeup.survey = options_.survey;
  options_.closeup.take = options_.take;
  options_.closeup.calibrate = options_.calibrate;
  options_.search.take = options_.take;
  options_.search.calibrate = options_.calibrate;
}

std::unique_ptr<calibrate::Calibrator> MountFinder::make_calibrator() {
  if (follower_) return std::move(follower_);
  return mount_ ? calibrator_of(setup_, options_.calibrate, pitch_, *mount_, initial_) : nullptr;
}

std::vector<std::string> MountFinder::take_notes() { return std::exchange(notes_, {}); }

// Work gives a Found and is done with what it was given by value. Only one is under way at a time.
template <typename Work>
void MountFinder::start(Work work) {
  std::promise<Found> promise;
  work_ = promise.get_future();
  executor_.post([work = std::move(work), promise = std::move(promise)]() mutable {
    Found found;
    found.time.stage = "survey";
    {
      const StageTimer timer(found.time);
      work(found);
    }
    promise.set_value(std::move(found));
  });
}

std::optional<MountFinder::Found> MountFinder::arrived() {
  if (!work_.valid() || work_.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
    return std::nullopt;
  Found found = work_.get();
  time_.seconds += found.time.seconds;
  time_.frames += found.time.frames;
  if (found.take) take_ = std::move(found.take);
  return found;
}

// Sizes that nobody measured are those that the lines say from here on, and so are stated ones that
// the lines contradict.
void MountFinder::adopt_sizes(const calibrate::SurveyResult& result) {
  pitch::PitchSizes sizes = setup_.sizes;
  if (result.refuted.any())
    note(
        fmt::format("the stated pitch of {:.2f} x {:.2f} m with a crown of {:.2f} m is not what "
                    "the lines show: measure it and state its sizes",
                    pitch_.length_m, pitch_.width_m, pitch_.crown_m));
  if (result.refuted(0)) sizes.length_m.reset();
  if (result.refuted(1)) sizes.width_m.reset();
  if (result.refuted(2)) sizes.crown_m.reset();
  if (!sizes.length_m) sizes.length_m = result.length_m;
  if (!sizes.width_m) sizes.width_m = result.width_m;
  if (!sizes.crown_m) sizes.crown_m = result.crown_m;
  auto found = pitch::make_pitch(setup_.sport, sizes);
  if (!found) return;
  if (found->length_m != pitch_.length_m || found->width_m != pitch_.width_m ||
      found->crown_m != pitch_.crown_m) {
    note(fmt::format("pitch by its lines: {:.2f} x {:.2f} m, crown {:.2f} m", found->length_m,
                     found->width_m, found->crown_m));
  }
  pitch_ = std::move(*found);
}

void MountFinder::adopt(const calibrate::SurveyResult& result) {
  mount_ = result.mount;
  rms_px_ = result.rms_px;
  solved_ = result.solved;
  adopt_sizes(result);
  const Eigen::Vector3d p = mount_->position_in_world;
  note(fmt::format("surveyed: {} pictures solved, rms {:.2f} px, position {:.2f} {:.2f} {:.2f} m",
                   result.solved, result.rms_px, p.x(), p.y(), p.z()));
}

// From here on the mount and the pitch are those of the take's survey.
void MountFinder::adopt(const calibrate::TakeSurveyResult& result) {
  mount_ = result.mount;
  pitch_ = result.pitch;
  rms_px_ = result.rms_px;
  solved_ = result.key_frames;
}

void MountFinder::note_take(const calibrate::TakeSurveyResult& result) {
  const Eigen::Vector3d p = result.mount.position_in_world;
  note(
      fmt::format("surveyed from {} views of the take: rms {:.2f} px, position {:.2f} {:.2f} "
                  "{:.2f} m, moved {:.2f} m, pitch {:.2f} x {:.2f} m",
                  result.key_frames, result.rms_px, p.x(), p.y(), p.z(), result.moved_m,
                  result.pitch.length_m, result.pitch.width_m));
}

std::vector<geometry::CameraEstimate> MountFinder::from_stills(
    std::span<const image::Frame> stills) {
  const StageTimer timer(time_);
  // Stills of the whole pitch may say that the club is wrong; one picture of a take may not.
  calibrate::SurveyOptions options = options_.survey;
  options.correct_stated = true;
  auto result = calibrate::survey(stills, pitch_, setup_.side, options);
  if (!result) {
    if (setup_.kind != HeadKind::kCloseup) error_ = result.error();
    stills_failed_ = true;
    note("survey failed: " + base::to_string(result.error()));
    return {};
  }
  adopt(*result);
  return std::move(result->stills);
}

// A camera without survey stills is solved from what it shows: a fixed one from its frames
// together; a head, which may move, from the first of a few that can be.
MountFinder::FirstMount MountFinder::first_mount(const ChainSetup& setup,
                                                 const MountOptions& options,
                                                 const pitch::PitchModel& pitch,
                                                 std::span<const image::FramePtr> shown) {
  FirstMount out;
  if (setup.kind == HeadKind::kFixed) {
    std::vector<image::Frame> frames;
    for (const std::size_t i : spread(shown.size(), options.fixed_frames))
      frames.push_back(*shown[i]);
    out.result = calibrate::survey_fixed(frames, pitch, setup.side, options.survey);
  } else {
    out.result = survey_head(setup, options.survey, pitch, shown, out.solved);
  }
  return out;
}

void MountFinder::adopt_first(FirstMount first) {
  if (!first.result) {
    if (setup_.kind != HeadKind::kCloseup) error_ = first.result.error();
    note("not calibrated: " + base::to_string(first.result.error()));
    return;
  }
  error_.reset();
  adopt(*first.result);
  if (first.solved == 0) initial_ = first.result->stills.front();
  if (setup_.kind == HeadKind::kHead) take_.emplace(pitch_, *mount_, options_.take);
}

// What one picture said of the mount is rough: the held frames are followed, with what their views
// together say, until they say nothing new.
void MountFinder::follow_held(std::span<const image::FramePtr> held) {
  std::optional<calibrate::TakeSurveyResult> last;
  for (int pass = 0; take_ && pass < kTakePasses; ++pass) {
    const auto calibrator = make_calibrator();
    for (const image::FramePtr& frame : held)
      if (const auto estimate = calibrator->process(*frame).estimate;
          estimate.evidence == geometry::Evidence::kLines)
        take_->add(*frame, estimate);
    auto result = take_->solve();
    if (!result) break;
    adopt(*result);
    initial_.reset();  // the newest view is not the first frame's
    last = std::move(result);
  }
  if (last) note_take(*last);
}

bool MountFinder::from_take(std::span<const image::FramePtr> pictures) {
  if (mount_ || stills_failed_ || setup_.kind != HeadKind::kHead) return false;
  const StageTimer timer(time_);
  auto found = calibrate::search_take(pictures, pitch_, setup_.side, options_.search);
  if (!found) {
    note("not calibrated by the take: " + base::to_string(found.error()));
    return false;
  }
  take_ = std::move(found->survey);
  mount_ = take_->mount();
  pitch_ = take_->pitch();
  rms_px_ = found->rms_px;
  solved_ = found->solved;
  if (!found->first.lost()) {
    initial_ = found->first;
    initial_->covariance.setZero();
  }
  const Eigen::Vector3d p = mount_->position_in_world;
  note(
      fmt::format("surveyed from the take: {} of {} pictures, rms {:.2f} px, position {:.2f} "
                  "{:.2f} {:.2f} m, pitch {:.2f} x {:.2f} m",
                  found->solved, pictures.size(), found->rms_px, p.x(), p.y(), p.z(),
                  pitch_.length_m, pitch_.width_m));
  return true;
}

void MountFinder::from_held(std::span<const image::FramePtr> held) {
  if (mount_ || stills_failed_ || held.empty()) return;
  if (setup_.kind == HeadKind::kCloseup) {
    survey_stretch({held.begin(), held.end()});
    auto found = arrived();
    if (!found) return note("not calibrated yet: the close-up's first frames are being surveyed");
    if (!*found->closeup)
      return note("not calibrated: " + base::to_string(found->closeup->error()));
    if (const auto& first = (*found->closeup)->first; !first.lost()) initial_ = first;
    return adopt(std::move(**found->closeup));
  }
  const StageTimer timer(time_);
  adopt_first(first_mount(setup_, options_, pitch_, held));
  follow_held(held);
}

// A close-up stands on all frames of a stretch or on none.
void MountFinder::survey_stretch(std::vector<image::FramePtr> frames) {
  stretch_wait_s_ =
      std::max(options_.retry_s, std::min(2 * stretch_wait_s_, options_.most_stretch_wait_s));
  frames_since_survey_ = 0;
  start([setup = setup_, options = options_, pitch = pitch_,
         frames = std::move(frames)](Found& found) {
    found.closeup = calibrate::survey_closeup(frames, pitch, setup.side, options.closeup);
    if (!*found.closeup) return;
    const calibrate::CloseupSurvey& survey = **found.closeup;
    std::optional<geometry::CameraEstimate> first;
    if (!survey.first.lost()) first = survey.first;
    found.follower =
        calibrator_of(setup, options.calibrate, survey.take.pitch, survey.take.mount, first);
    for (const image::FramePtr& frame : frames) found.follower->process(*frame);
  });
}

void MountFinder::adopt(calibrate::CloseupSurvey survey) {
  adopt(survey.take);
  note_take(survey.take);
  take_.emplace(pitch_, *mount_, options_.closeup.views());
}

// The head may have come to show more: its newest frames are tried, ever more rarely.
MountFinder::Change MountFinder::retry_closeup(const image::FramePtr& frame) {
  ++frames_since_survey_;
  const double rate = setup_.rate.hz();
  const auto stride = std::max<std::uint64_t>(1, std::llround(rate / kStretchHz));
  if (!work_.valid() && frames_since_survey_ % stride == 0) {
    std::uint64_t bytes = 0;
    for (const auto& plane : frame->planes) bytes += plane.size() * sizeof(std::uint16_t);
    const auto full = static_cast<std::size_t>(
        std::max(2.0, std::min(options_.stretch_s * rate / static_cast<double>(stride),
                               options_.stretch_mib * 1048576.0 / static_cast<double>(bytes + 1))));
    stretch_.push_back(frame);
    if (stretch_.size() > full) stretch_.pop_front();
    if (stretch_.size() == full &&
        static_cast<double>(frames_since_survey_) >= stretch_wait_s_ * rate) {
      survey_stretch({stretch_.begin(), stretch_.end()});
      stretch_.clear();
    }
  }
  auto found = arrived();
  if (!found || !found->closeup) return Change::kNone;
  if (!*found->closeup) {
    note("not calibrated: " + base::to_string(found->closeup->error()));
    return Change::kNone;
  }
  adopt(std::move(**found->closeup));
  follower_ = std::move(found->follower);
  stretch_.clear();
  return Change::kMount;
}

MountFinder::Change MountFinder::retry(const image::FramePtr& frame) {
  if (mount_ || stills_failed_) return Change::kNone;
  if (setup_.kind == HeadKind::kCloseup) return retry_closeup(frame);
  const bool waited =
      static_cast<double>(++frames_since_survey_) >= options_.retry_s * setup_.rate.hz();
  const bool started = waited && !work_.valid();
  if (started) {
    frames_since_survey_ = 0;
    start([setup = setup_, options = options_, pitch = pitch_, frame](Found& found) {
      found.first = first_mount(setup, options, pitch, std::span(&frame, 1));
    });
  }
  auto found = arrived();
  if (!found || !found->first) return Change::kNone;
  adopt_first(std::move(*found->first));
  if (!started) initial_.reset();  // of a frame that is past
  return mount_ ? Change::kMount : Change::kNone;
}

// Lines that come into view may show that the pitch has another size than the default. It takes a
// second of work: a cutaway to the crowd must not ask for it every second.
void MountFinder::look_for_sizes(const image::FramePtr& frame) {
  if (frames_until_sizes_ > 0) {
    --frames_until_sizes_;
    return;
  }
  frames_until_sizes_ = sizes_wait_;
  sizes_wait_ = std::min(2 * sizes_wait_, static_cast<int>(kMostSizesWait_s * setup_.rate.hz()));
  start([take = std::move(*take_), frame](Found& found) mutable {
    found.resized = take.resize(*frame);
    found.take = std::move(take);
  });
  take_.reset();
}

MountFinder::Change MountFinder::follow(const image::FramePtr& frame,
                                        const geometry::CameraEstimate& estimate) {
  if (!mount_) return Change::kNone;
  std::optional<Found> found = arrived();  // of earlier frames
  const bool late = found.has_value();
  bool news = late;
  if (take_) {
    if (!estimate.lost()) {
      frames_until_sizes_ = 0;
      sizes_wait_ = static_cast<int>(setup_.rate.hz());
      const StageTimer timer(time_);
      if (take_->add(*frame, estimate) && !late) {
        start([take = std::move(*take_)](Found& out) mutable {
          out.joint = take.solve();
          out.take = std::move(take);
        });
        take_.reset();
      }
    } else if (!better_ && !late) {  // a better mount is tried before other sizes
      look_for_sizes(frame);
    }
    if (!late) found = arrived();
    news = news || found.has_value();
  }
  if (found && found->joint) better_ = std::move(found->joint);
  if (found && found->resized) {
    pitch_ = take_->pitch();
    mount_ = take_->mount();
    initial_ = std::move(found->resized);
    if (late) initial_.reset();
    note(fmt::format("pitch by the lines that came into view: {:.1f} x {:.1f} m", pitch_.length_m,
                     pitch_.width_m));
    return Change::kSizes;
  }
  if (!better_ || (!news && !estimate.lost())) return Change::kNone;
  const double scale = frame->height() / 1080.0;
  const bool misfit = better_->rms_before_px > kTakeMisfitPx * scale &&
                      better_->rms_before_px > kTakeMisfit * better_->rms_px;
  if (!estimate.lost() && !misfit) return Change::kNone;
  std::optional<geometry::CameraEstimate> next;
  if (!estimate.lost()) {
    // A frame that is followed must not be lost to a mount that ought to be better.
    next = late ? estimate : better_->newest;
    next->covariance.setZero();
    auto trial = calibrator_of(setup_, options_.calibrate, better_->pitch, better_->mount, next);
    if (trial->process(*frame).estimate.evidence != geometry::Evidence::kLines) {
      better_.reset();
      return Change::kNone;
    }
  }
  adopt(*better_);
  note_take(*better_);
  initial_ = std::move(next);
  better_.reset();
  return Change::kMount;
}

}  // namespace touchline::edge
