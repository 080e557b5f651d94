#include "edge/frame_chain.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <deque>
#include <map>
#include <optional>

#include "edge/compensate/compensator.h"
#include "shared/geometry/mount.h"

namespace touchline::edge {
namespace {

constexpr int kTakePictures = 3;  // held frames that are tried for a head's first mount
// What one picture may say of the sizes against the usual ones, and of a crown; metres.
constexpr double kLengthOff = 12;
constexpr double kWidthOff = 7;
constexpr double kMostCrown = 0.6;
constexpr double kAnySize = 100;  // metres: a size that is not held against the lines
constexpr double kMostSizesWait_s = 60;
constexpr int kTakePasses = 4;         // over the held frames, for the survey of a take
constexpr double kTakeMisfitPx = 0.3;  // rms of a mount's lines at 1080 lines, to look for a better
constexpr double kTakeMisfit = 1.3;    // and so much more than the better one's

using Clock = std::chrono::steady_clock;

// Adds the time until it ends to a stage.
class StageTimer {
 public:
  explicit StageTimer(StageTime& stage) : stage_(stage), start_(Clock::now()) {}
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;
  ~StageTimer() {
    stage_.seconds += std::chrono::duration<double>(Clock::now() - start_).count();
    ++stage_.frames;
  }

 private:
  StageTime& stage_;
  Clock::time_point start_;
};

enum Stage { kCompensate, kSurvey, kCalibrate, kPlate, kKey, kEncode, kStages };

base::Status out_of_bounds(const char* field, double value, const char* bound) {
  return base::fail(base::ErrorKind::kConfiguration, field,
                    fmt::format("{} is out of bounds", value),
                    fmt::format("use a value in {}", bound));
}

// `count` indices spread over 0 .. size - 1, rising and distinct.
std::vector<std::size_t> spread(std::size_t size, int count) {
  std::vector<std::size_t> indices;
  const std::size_t n = std::min(size, static_cast<std::size_t>(std::max(count, 1)));
  for (std::size_t i = 0; i < n; ++i) indices.push_back(n == 1 ? 0 : i * (size - 1) / (n - 1));
  return indices;
}

compensate::Compensator compensator_of(const compensate::DetailOptions& options,
                                       const std::vector<image::FramePtr>& frames, int looked_at,
                                       state::DetailModel& model) {
  compensate::DetailEstimator estimator(options);
  for (const std::size_t i : spread(frames.size(), looked_at)) estimator.add(frames[i]->luma());
  model = estimator.estimate();
  return compensate::Compensator(model);
}

calibrate::SurveyOptions survey_options(const ChainSetup& setup, const ChainOptions& options) {
  calibrate::SurveyOptions out = options.survey;
  out.length_stated = setup.sizes.length_m.has_value();
  out.width_stated = setup.sizes.width_m.has_value();
  out.crown_stated = setup.sizes.crown_m.has_value();
  return out;
}

}  // namespace

base::Status ChainOptions::validate() const {
  if (!(hold_back_s >= 0 && hold_back_s <= 2))
    return out_of_bounds("hold_back_s", hold_back_s, "0..2");
  if (hold_back_mib < 16 || hold_back_mib > 65536)
    return out_of_bounds("hold_back_mib", hold_back_mib, "16..65536");
  if (!(survey_retry_s >= 0.1 && survey_retry_s <= 3600)) {
    return out_of_bounds("survey_retry_s", survey_retry_s, "0.1..3600");
  }
  if (detail_frames < 1 || detail_frames > 50)
    return out_of_bounds("detail_frames", detail_frames, "1..50");
  if (fixed_survey_frames < 1 || fixed_survey_frames > 64) {
    return out_of_bounds("fixed_survey_frames", fixed_survey_frames, "1..64");
  }
  if (plate_publish_frames < 1 || plate_publish_frames > 100000) {
    return out_of_bounds("plate_publish_frames", plate_publish_frames, "1..100000");
  }
  for (const base::Status& part : {detail.validate(), survey.validate(), take.validate(),
                                   calibrate.validate(), plate.validate(), key.validate(),
                                   encode.validate(), codec.validate(), plate_tiles.validate()}) {
    if (!part) return part;
  }
  return {};
}

base::Result<calibrate::SurveyResult> survey_mount(const ChainSetup& setup,
                                                   const ChainOptions& options,
                                                   std::vector<image::Frame>& stills) {
  auto pitch = pitch::make_pitch(setup.sport, setup.sizes);
  if (!pitch) return base::fail(pitch.error());
  std::vector<image::FramePtr> frames;
  for (image::Frame& still : stills)
    frames.push_back(std::make_shared<const image::Frame>(std::move(still)));
  state::DetailModel detail;
  const auto undo = compensator_of(options.detail, frames, static_cast<int>(frames.size()), detail);
  for (std::size_t i = 0; i < frames.size(); ++i) stills[i] = undo.apply(*frames[i]);
  return calibrate::survey(stills, *pitch, setup.side, survey_options(setup, options));
}

struct FrameChain::Impl {
  ChainSetup setup;
  ChainOptions options;
  pitch::PitchModel pitch;
  std::vector<image::Frame> stills;  // until the plate is seeded
  std::vector<geometry::CameraEstimate> still_estimates;

  // Active state.
  std::optional<geometry::Mount> mount;
  std::optional<geometry::CameraEstimate> initial;  // of the first frame, where the survey gave it
  std::optional<calibrate::TakeSurvey> take;        // of a head without survey stills
  std::optional<calibrate::TakeSurveyResult> better;  // found while running, not adopted yet
  std::unique_ptr<calibrate::Calibrator> calibrator;
  std::unique_ptr<compensate::Compensator> compensator;
  std::unique_ptr<plate::PlateBuilder> plate;
  std::uint32_t plate_version = 1;  // of its first snapshot
  key::Keyer keyer;
  std::shared_ptr<const image::PlateSnapshot> sent_plate;
  std::vector<image::FramePtr> held;
  bool running = false;  // the hold-back is over
  bool calibrated_any = false;
  int sizes_wait = 1;          // frames, after the next look for them
  int frames_until_sizes = 0;  // of lost frames, until the pitch's sizes are looked for again
  bool stills_failed = false;
  std::uint64_t held_bytes = 0;
  std::uint64_t frames_since_survey = 0;
  std::uint64_t frames_since_plate = 0;

  ChainReport report;
  std::vector<std::string> notes;

  StageTime& stage(Stage s) { return report.stages[s]; }

  void note(std::string text) { notes.push_back(std::move(text)); }

  // Sizes that nobody measured are those that the lines say from here on.
  void adopt_sizes(const calibrate::SurveyResult& result) {
    pitch::PitchSizes sizes = setup.sizes;
    if (!sizes.length_m) sizes.length_m = result.length_m;
    if (!sizes.width_m) sizes.width_m = result.width_m;
    if (!sizes.crown_m) sizes.crown_m = result.crown_m;
    auto found = pitch::make_pitch(setup.sport, sizes);
    if (!found) return;
    if (found->length_m != pitch.length_m || found->width_m != pitch.width_m ||
        found->crown_m != pitch.crown_m) {
      note(fmt::format("pitch by its lines: {:.2f} x {:.2f} m, crown {:.2f} m", found->length_m,
                       found->width_m, found->crown_m));
    }
    pitch = std::move(*found);
  }

  void adopt(const calibrate::SurveyResult& result) {
    mount = result.mount;
    report.survey_rms_px = result.rms_px;
    report.survey_solved = result.solved;
    adopt_sizes(result);
    const Eigen::Vector3d p = mount->position_in_world;
    note(fmt::format("surveyed: {} pictures solved, rms {:.2f} px, position {:.2f} {:.2f} {:.2f} m",
                     result.solved, result.rms_px, p.x(), p.y(), p.z()));
  }

  void survey_stills() {
    const StageTimer timer(stage(kSurvey));
    auto result = survey_mount(setup, options, stills);
    if (!result) {
      if (setup.kind != HeadKind::kCloseup) report.survey_error = result.error();
      stills_failed = true;
      note("survey failed: " + base::to_string(result.error()));
      return;
    }
    still_estimates = result->stills;
    adopt(*result);
  }

  // The first mount of a head from one picture, the usual sizes of a pitch first: one picture tells
  // little of them. Then with those that nobody measured free, if they come out like a pitch's.
  base::Result<calibrate::SurveyResult> survey_head(const std::vector<image::FramePtr>& shown,
                                                    std::size_t& solved) const {
    calibrate::SurveyOptions usual = options.survey;
    const std::array<std::pair<bool*, bool>, 3> sizes{
        {{&usual.length_stated, setup.sizes.length_m.has_value()},
         {&usual.width_stated, setup.sizes.width_m.has_value()},
         {&usual.crown_stated, setup.sizes.crown_m.has_value()}}};
    for (const auto& [stated, measured] : sizes) {
      if (!measured) usual.size_tolerance_m = kAnySize;
      *stated = true;
    }
    base::Result<calibrate::SurveyResult> result = base::fail(base::Error{});
    const std::array<const calibrate::SurveyOptions*, 2> tries{&usual, &options.survey};
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

  // A camera without survey stills is solved from what it shows: a fixed one from its frames
  // together; a head, which may move, from the first of a few that can be.
  void survey_frames(const std::vector<image::FramePtr>& shown) {
    if (shown.empty()) return;
    const StageTimer timer(stage(kSurvey));
    std::size_t solved = 0;
    base::Result<calibrate::SurveyResult> result = base::fail(base::Error{});
    if (setup.kind == HeadKind::kFixed) {
      std::vector<image::Frame> frames;
      for (const std::size_t i : spread(shown.size(), options.fixed_survey_frames))
        frames.push_back(*shown[i]);
      result = calibrate::survey_fixed(frames, pitch, setup.side, options.survey);
    } else {
      result = survey_head(shown, solved);
    }
    if (!result) {
      if (setup.kind != HeadKind::kCloseup) report.survey_error = result.error();
      note("not calibrated: " + base::to_string(result.error()));
      return;
    }
    report.survey_error.reset();
    adopt(*result);
    if (solved == 0) initial = result->stills.front();
    if (setup.kind == HeadKind::kHead) take.emplace(pitch, *mount, options.take);
  }

  // Says nothing but the picture's size.
  static geometry::CameraEstimate lost(const image::Frame& frame) {
    geometry::CameraEstimate estimate;
    estimate.model.width = frame.width();
    estimate.model.height = frame.height();
    return estimate;
  }

  geometry::CameraEstimate calibrate_frame(const image::Frame& frame) {
    const StageTimer timer(stage(kCalibrate));
    geometry::CameraEstimate estimate = lost(frame);
    std::string why;
    if (calibrator) {
      state::TrackResult tracked = calibrator->process(frame);
      if (tracked.estimate.lost()) {
        why = ": " + tracked.report.stopped_because;
      } else {
        estimate = std::move(tracked.estimate);
      }
    }
    if (estimate.evidence != report.calibration || !calibrated_any) {
      note(fmt::format("calibration: {} from frame {} on{}", geometry::name(estimate.evidence),
                       frame.id.sequence, why));
    }
    calibrated_any = true;
    report.calibration = estimate.evidence;
    return estimate;
  }

  void start_calibrator() {
    if (!mount) return;
    calibrate::CalibrateOptions calibrate_options = options.calibrate;
    calibrate_options.fixed = setup.kind == HeadKind::kFixed;
    calibrator = std::make_unique<calibrate::Calibrator>(pitch, *mount, calibrate_options);
    if (initial) calibrator->start_from(*initial);
  }

  // From here on the mount and the pitch are those of the take's survey.
  void adopt(const calibrate::TakeSurveyResult& result) {
    mount = result.mount;
    pitch = result.pitch;
    initial = result.newest;
    report.survey_rms_px = result.rms_px;
    report.survey_solved = result.key_frames;
  }

  void note_take(const calibrate::TakeSurveyResult& result) {
    const Eigen::Vector3d p = result.mount.position_in_world;
    note(
        fmt::format("surveyed from {} views of the take: rms {:.2f} px, position {:.2f} {:.2f} "
                    "{:.2f} m, moved {:.2f} m, pitch {:.2f} x {:.2f} m",
                    result.key_frames, result.rms_px, p.x(), p.y(), p.z(), result.moved_m,
                    result.pitch.length_m, result.pitch.width_m));
  }

  // What one picture said of the mount is rough: the held frames are followed, with what their
  // views together say, until they say nothing new. Then they are followed for good.
  void survey_held() {
    std::optional<calibrate::TakeSurveyResult> last;
    for (int pass = 0; take && pass < kTakePasses; ++pass) {
      start_calibrator();
      const StageTimer timer(stage(kSurvey));
      for (const image::FramePtr& frame : held)
        take->add(*frame, calibrator->process(*frame).estimate);
      auto result = take->solve();
      if (!result) break;
      adopt(*result);
      initial.reset();  // the newest view is not the first frame's
      last = std::move(result);
    }
    if (last) note_take(*last);
  }

  // Lines that come into view may show that the pitch has another size than the default.
  void find_sizes(const image::Frame& frame, geometry::CameraEstimate& estimate) {
    if (frames_until_sizes > 0) {
      --frames_until_sizes;
      return;
    }
    // It takes a second of work: a cutaway to the crowd must not hold a live unit up every second.
    frames_until_sizes = sizes_wait;
    sizes_wait = std::min(2 * sizes_wait, static_cast<int>(kMostSizesWait_s * setup.rate.hz()));
    std::optional<geometry::CameraEstimate> found;
    {
      const StageTimer timer(stage(kSurvey));
      found = take->resize(frame);
    }
    if (!found) return;
    pitch = take->pitch();
    initial = std::move(found);
    start_calibrator();
    estimate = calibrate_frame(frame);
    note(fmt::format("pitch by the lines that came into view: {:.1f} x {:.1f} m", pitch.length_m,
                     pitch.width_m));
  }

  // While running: another view, and what all views then say. It is adopted when the mount as it is
  // fits them worse, or does not let the lines be followed, since the plate begins anew with it.
  void survey_running(const image::Frame& frame, geometry::CameraEstimate& estimate) {
    if (!take) return;
    if (!estimate.lost()) {
      frames_until_sizes = 0;
      sizes_wait = static_cast<int>(setup.rate.hz());
      const StageTimer timer(stage(kSurvey));
      if (!take->add(frame, estimate)) return;
      if (auto result = take->solve()) better = std::move(result);
    }
    // Other sizes are looked for only when there is no better mount to try first.
    if (estimate.lost() && !better) find_sizes(frame, estimate);
    if (!better) return;
    const double scale = frame.height() / 1080.0;
    const bool misfit = better->rms_before_px > kTakeMisfitPx * scale &&
                        better->rms_before_px > kTakeMisfit * better->rms_px;
    if (!estimate.lost() && !misfit) return;
    adopt(*better);
    note_take(*better);
    if (estimate.lost()) initial.reset();
    better.reset();
    start_calibrator();
    estimate = calibrate_frame(frame);
    if (const auto old = plate ? plate->snapshot() : nullptr) plate_version = old->version + 1;
    plate.reset();
  }

  // A camera that showed no pitch at first (a cap, a test card) is tried again now and then.
  void retry_survey(const image::FramePtr& frame) {
    if (mount || stills_failed || setup.kind == HeadKind::kCloseup) return;
    if (static_cast<double>(++frames_since_survey) < options.survey_retry_s * setup.rate.hz())
      return;
    frames_since_survey = 0;
    survey_frames({frame});
    start_calibrator();
  }

  void learn_plate(const image::Frame& frame, const geometry::CameraEstimate& estimate) {
    if (!plate || estimate.lost()) return;
    const StageTimer timer(stage(kPlate));
    plate->add(frame, estimate);
  }

  void start_plate(const std::vector<geometry::CameraEstimate>& estimates) {
    double focal = 0;
    for (const geometry::CameraEstimate& estimate : estimates) {
      if (!estimate.lost()) focal = std::max(focal, estimate.model.fx);
    }
    if (focal <= 0 || !mount) return;
    plate::PlateOptions plate_options = options.plate;
    plate_options.first_version = plate_version;
    plate = std::make_unique<plate::PlateBuilder>(pitch, mount->position_in_world, 1 / focal,
                                                  plate_options);
    const StageTimer timer(stage(kPlate));
    for (std::size_t i = 0; i < still_estimates.size(); ++i)
      plate->seed(stills[i], still_estimates[i]);
    stills.clear();
    still_estimates.clear();
  }

  codec::EncodedView encode_frame(const image::Frame& frame,
                                  const geometry::CameraEstimate& estimate,
                                  const std::shared_ptr<const image::PlateSnapshot>& snapshot) {
    ++report.frames_out;
    codec::EncodedView bare{frame.id, frame.stamp, estimate, {}};
    if (estimate.lost()) ++report.frames_lost;
    if (estimate.lost() || snapshot == nullptr) return bare;
    state::KeyResult keyed;
    {
      const StageTimer timer(stage(kKey));
      keyed = keyer.key(frame, estimate, snapshot, pitch, options.key);
    }
    const StageTimer timer(stage(kEncode));
    auto encoded = codec::encode(
        encode::assemble(frame, estimate, std::move(keyed.matte), pitch, options.encode),
        options.codec);
    if (!encoded) {
      encoder_failed(encoded.error());
      return bare;
    }
    return std::move(*encoded);
  }

  void publish_plate(ChainOutput& out) {
    if (!plate) return;
    const StageTimer timer(stage(kEncode));
    const auto snapshot = plate->snapshot(true);
    frames_since_plate = 0;
    if (!snapshot || snapshot == sent_plate) return;
    for (const auto& [key, tile] : snapshot->tiles) {
      if (sent_plate) {
        const auto before = sent_plate->tiles.find(key);
        if (before != sent_plate->tiles.end() && before->second == tile) continue;
      }
      auto encoded = codec::encode_plate_tile(setup.camera, *snapshot, key, options.plate_tiles);
      if (encoded) {
        out.plates.push_back(std::move(*encoded));
      } else {
        encoder_failed(encoded.error());
      }
    }
    sent_plate = snapshot;
  }

  ChainOutput done(ChainOutput out) {
    out.notes = std::move(notes);
    notes.clear();
    return out;
  }

  void encoder_failed(const base::Error& error) {
    ++report.encode_failures;
    note(base::to_string(error));
  }

  // The end of the hold-back: everything that is learnt from the first frames, then those frames.
  ChainOutput release() {
    running = true;
    ChainOutput out;
    if (held.empty()) return done(std::move(out));
    {
      const StageTimer timer(stage(kCompensate));
      compensator = std::make_unique<compensate::Compensator>(
          compensator_of(options.detail, held, options.detail_frames, report.detail));
      note(fmt::format("detail: horizontal {:.2f} {:.2f}, vertical {:.2f} {:.2f} from {} edges",
                       report.detail.horizontal[0], report.detail.horizontal[1],
                       report.detail.vertical[0], report.detail.vertical[1], report.detail.edges));
    }
    for (image::FramePtr& frame : held) frame = compensated(*frame);
    if (!mount && !stills_failed) survey_frames(held);
    survey_held();
    start_calibrator();
    std::vector<geometry::CameraEstimate> estimates;
    for (const image::FramePtr& frame : held) estimates.push_back(calibrate_frame(*frame));
    start_plate(estimates);
    for (std::size_t i = 0; i < held.size(); ++i) learn_plate(*held[i], estimates[i]);
    publish_plate(out);
    for (std::size_t i = 0; i < held.size(); ++i) {
      out.views.push_back(encode_frame(*held[i], estimates[i], sent_plate));
      held[i].reset();
    }
    held.clear();
    return done(std::move(out));
  }

  image::FramePtr compensated(const image::Frame& frame) {
    const StageTimer timer(stage(kCompensate));
    return std::make_shared<const image::Frame>(compensator->apply(frame));
  }
};

FrameChain::FrameChain(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
FrameChain::FrameChain(FrameChain&&) noexcept = default;
FrameChain& FrameChain::operator=(FrameChain&&) noexcept = default;
FrameChain::~FrameChain() = default;

base::Result<FrameChain> FrameChain::make(const ChainSetup& setup, const ChainOptions& options,
                                          std::vector<image::Frame> stills) {
  if (base::Status status = options.validate(); !status) return base::fail(status.error());
  auto impl = std::make_unique<Impl>();
  impl->setup = setup;
  impl->options = options;
  impl->options.survey = survey_options(setup, options);
  impl->options.take.survey = impl->options.survey;
  auto pitch = pitch::make_pitch(setup.sport, setup.sizes);
  if (!pitch) return base::fail(pitch.error());
  impl->pitch = std::move(*pitch);
  impl->stills = std::move(stills);
  impl->report.stages = {{"compensate", 0, 0}, {"survey", 0, 0}, {"calibrate", 0, 0},
                         {"plate", 0, 0},      {"key", 0, 0},    {"encode", 0, 0}};
  if (!impl->stills.empty()) impl->survey_stills();
  return FrameChain(std::move(impl));
}

ChainOutput FrameChain::push(image::FramePtr frame) {
  ++impl_->report.frames_in;
  if (!impl_->running) {
    for (const auto& plane : frame->planes)
      impl_->held_bytes += plane.size() * sizeof(std::uint16_t);
    impl_->held.push_back(std::move(frame));
    const double needed = impl_->options.hold_back_s * impl_->setup.rate.hz();
    const auto budget = static_cast<std::uint64_t>(impl_->options.hold_back_mib) << 20;
    if (static_cast<double>(impl_->held.size()) < std::max(needed, 1.0) &&
        impl_->held_bytes < budget) {
      return impl_->done({});
    }
    return impl_->release();
  }
  ChainOutput out;
  const image::FramePtr clean = impl_->compensated(*frame);
  impl_->retry_survey(clean);
  geometry::CameraEstimate estimate = impl_->calibrate_frame(*clean);
  impl_->survey_running(*clean, estimate);
  if (!impl_->plate && !estimate.lost()) impl_->start_plate({estimate});
  impl_->learn_plate(*clean, estimate);
  if (++impl_->frames_since_plate >=
      static_cast<std::uint64_t>(impl_->options.plate_publish_frames)) {
    impl_->publish_plate(out);
  }
  const auto snapshot = impl_->plate ? impl_->plate->snapshot() : nullptr;
  out.views.push_back(impl_->encode_frame(*clean, estimate, snapshot));
  return impl_->done(std::move(out));
}

ChainOutput FrameChain::finish() {
  if (!impl_->running) return impl_->release();
  ChainOutput out;
  impl_->publish_plate(out);
  return impl_->done(std::move(out));
}

ChainReport FrameChain::report() const { return impl_->report; }

}  // namespace touchline::edge
