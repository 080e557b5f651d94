#include "edge/frame_chain.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "edge/calibrate/follow_back.h"
#include "edge/chain_internal.h"
#include "edge/compensate/compensator.h"
#include "edge/key/training_order.h"
#include "shared/base/bounds.h"

namespace touchline::edge {
namespace {

constexpr double kPlateSdPx = 1;  // of a picture that the plate learns from, at 1080 lines

enum Stage { kCompensate, kSurvey, kCalibrate, kPlate, kKey, kEncode };

compensate::Compensator compensator_of(const compensate::DetailOptions& options,
                                       const std::vector<image::FramePtr>& frames, int looked_at,
                                       state::DetailModel& model) {
  compensate::DetailEstimator estimator(options);
  for (const std::size_t i : spread(frames.size(), looked_at)) estimator.add(frames[i]->luma());
  model = estimator.estimate();
  return compensate::Compensator(model);
}

}  // namespace

base::Status ChainOptions::validate() const {
  if (!(hold_back_s >= 0 && hold_back_s <= 2))
    return base::out_of_bounds("hold_back_s", hold_back_s, "in 0..2");
  if (hold_back_mib < 16 || hold_back_mib > 65536)
    return base::out_of_bounds("hold_back_mib", hold_back_mib, "in 16..65536");
  if (detail_frames < 1 || detail_frames > 50)
    return base::out_of_bounds("detail_frames", detail_frames, "in 1..50");
  if (plate_publish_frames < 1 || plate_publish_frames > 100000) {
    return base::out_of_bounds("plate_publish_frames", plate_publish_frames, "in 1..100000");
  }
  for (const base::Status& part :
       {detail.validate(), burnt_in.validate(), mount.validate(), head.validate(), peers.validate(),
        plate.validate(), plate_file.validate(), key.validate(), encode.validate(),
        codec.validate(), plate_tiles.validate()}) {
    if (!part) return part;
  }
  return {};
}

void compensate_stills(const compensate::DetailOptions& options,
                       std::vector<image::Frame>& stills) {
  std::vector<image::FramePtr> frames;
  for (image::Frame& still : stills)
    frames.push_back(std::make_shared<const image::Frame>(std::move(still)));
  state::DetailModel detail;
  const auto undo = compensator_of(options, frames, static_cast<int>(frames.size()), detail);
  for (std::size_t i = 0; i < frames.size(); ++i) stills[i] = undo.apply(*frames[i]);
}

base::Result<calibrate::SurveyResult> survey_mount(const ChainSetup& setup,
                                                   const ChainOptions& options,
                                                   std::vector<image::Frame>& stills) {
  auto pitch = pitch::make_pitch(setup.sport, setup.sizes);
  if (!pitch) return base::fail(pitch.error());
  compensate_stills(options.detail, stills);
  calibrate::SurveyOptions survey = survey_options(setup, options.mount.survey);
  survey.correct_stated = true;
  return calibrate::survey(stills, *pitch, setup.side, survey);
}

struct FrameChain::Impl {
  ChainSetup setup;
  ChainOptions options;
  runtime::InlineExecutor at_once;   // where no other was given
  std::vector<image::Frame> stills;  // until the plate is seeded
  std::vector<geometry::CameraEstimate> still_estimates;

  // Active state.
  std::optional<MountFinder> finder;
  std::optional<HeadFollower> head;
  std::optional<PeerFollower> peers;
  std::unique_ptr<calibrate::Calibrator> calibrator;
  std::unique_ptr<compensate::Compensator> compensator;
  compensate::BurntIn graphics;
  std::optional<PlateKeeper> keeper;
  std::unique_ptr<plate::PlateBuilder> plate;
  std::uint32_t plate_version = 1;  // of its first snapshot
  key::Keyer keyer;
  std::shared_ptr<const image::PlateSnapshot> sent_plate;
  std::vector<image::FramePtr> held;
  std::vector<std::optional<head::HeadCounts>> held_counts;  // of those
  bool running = false;                                      // the hold-back is over
  bool calibrated_any = false;
  std::uint64_t held_bytes = 0;
  image::FramePtr newest;  // that went through the stages: what an operator clicks on
  std::uint64_t frames_since_plate = 0;

  ChainReport report;
  std::vector<std::string> notes;

  StageTime& stage(Stage s) { return report.stages[s]; }

  void note(std::string text) { notes.push_back(std::move(text)); }

  void note_survey() {
    for (std::string& text : finder->take_notes()) note(std::move(text));
  }

  void survey_stills() {
    {
      const StageTimer timer(stage(kSurvey));
      compensate_stills(options.detail, stills);
    }
    still_estimates = finder->from_stills(stills);
    note_survey();
  }

  // Says nothing but the picture's size.
  static geometry::CameraEstimate lost(const image::Frame& frame) {
    geometry::CameraEstimate estimate;
    estimate.model.width = frame.width();
    estimate.model.height = frame.height();
    return estimate;
  }

  // By people; they start lines and texture anew, which say it better where they can.
  geometry::CameraEstimate by_peers(const image::Frame& frame, const geometry::Mount& mount) {
    if (setup.kind == HeadKind::kFixed) return lost(frame);
    geometry::CameraEstimate found = peers->find(frame, finder->pitch(), mount);
    if (found.lost()) return lost(frame);
    calibrator->start_from(found);
    state::TrackResult tracked = calibrator->process(frame);
    if (!tracked.estimate.lost()) return std::move(tracked.estimate);
    return peers->believed(found) ? found : lost(frame);
  }

  // By lines and texture; else by the head's encoders, which start the lines anew where those were
  // lost.
  geometry::CameraEstimate calibrate_frame(const image::Frame& frame,
                                           const std::optional<head::HeadCounts>& counts) {
    const StageTimer timer(stage(kCalibrate));
    geometry::CameraEstimate estimate = lost(frame);
    std::string why;
    if (calibrator) {
      const geometry::Mount& mount = *finder->mount();
      head->observe(counts);
      if (calibrated_any && report.calibration != geometry::Evidence::kLines &&
          report.calibration != geometry::Evidence::kPlate) {
        if (const auto prior = head->prior(mount)) calibrator->start_from(*prior);
      }
      if (plate) calibrator->use_plate(plate->snapshot());
      state::TrackResult tracked = calibrator->process(frame);
      if (!tracked.estimate.lost()) {
        estimate = std::move(tracked.estimate);
        if (estimate.evidence == geometry::Evidence::kLines) head->learn(mount, estimate);
      } else {
        why = ": " + tracked.report.stopped_because;
        if (auto by_head = head->estimate(mount)) {
          estimate = std::move(*by_head);
        } else {
          estimate = by_peers(frame, mount);
        }
      }
      if (!estimate.lost() && estimate.evidence != geometry::Evidence::kPeers)
        peers->learn(frame, estimate);
      if (std::string text = head->take_note(); !text.empty()) note(std::move(text));
    }
    if (estimate.evidence != report.calibration || !calibrated_any) {
      note(fmt::format("calibration: {} from frame {} on{}", geometry::name(estimate.evidence),
                       frame.id.sequence, why));
    }
    calibrated_any = true;
    report.calibration = estimate.evidence;
    return estimate;
  }

  // What was found of mount or pitch is used from here on.
  void follow_anew(MountFinder::Change change) {
    note_survey();
    if (change == MountFinder::Change::kNone) return;
    calibrator = finder->make_calibrator();
    if (change == MountFinder::Change::kSizes) return;
    head->forget();
    peers->forget();
    if (const auto old = plate ? plate->snapshot() : nullptr) plate_version = old->version + 1;
    plate.reset();
  }

  // The plate learns from no camera that may have drifted: it would be found again in it.
  void learn_plate(const image::Frame& frame, const geometry::CameraEstimate& estimate) {
    // Encoders and people are not as sure as a plate must be.
    if (!plate || estimate.lost() || estimate.evidence == geometry::Evidence::kEncoder ||
        estimate.evidence == geometry::Evidence::kPeers)
      return;
    const double turned = std::hypot(estimate.covariance(0, 0), estimate.covariance(1, 1));
    if (estimate.evidence == geometry::Evidence::kPlate &&
        std::sqrt(turned) * estimate.model.fx > kPlateSdPx * frame.height() / 1080.0)
      return;
    const StageTimer timer(stage(kPlate));
    plate->add(frame, estimate);
    keeper->after_frame(*plate);
    note_plate();
  }

  void note_plate() {
    for (std::string& text : keeper->take_notes()) note(std::move(text));
  }

  // Held frames that were lost before one that was solved.
  void follow_held_back(std::vector<geometry::CameraEstimate>& estimates) {
    if (!finder->mount() || setup.kind == HeadKind::kFixed) return;
    const StageTimer timer(stage(kCalibrate));
    const int found = calibrate::follow_back(held, finder->pitch(), *finder->mount(),
                                             options.mount.calibrate, estimates);
    if (found > 0)
      note(fmt::format("calibration: {} lost frames were found from later ones", found));
  }

  // `frame` is one of those that the estimates are of.
  void start_plate(const std::vector<geometry::CameraEstimate>& estimates,
                   const image::Frame& frame) {
    double focal = 0;
    for (const geometry::CameraEstimate& estimate : estimates) {
      if (!estimate.lost()) focal = std::max(focal, estimate.model.fx);
    }
    if (focal <= 0 || !finder->mount()) return;
    plate::PlateOptions plate_options = options.plate;
    plate_options.first_version = plate_version;
    const StageTimer timer(stage(kPlate));
    plate = keeper->start(
        finder->pitch(),
        {finder->mount()->position_in_world, focal, frame.width(), frame.height(), frame.colour},
        plate_options);
    note_plate();
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
    if (estimate.evidence == geometry::Evidence::kEncoder) ++report.frames_by_head;
    if (estimate.evidence == geometry::Evidence::kPeers) ++report.frames_by_peers;
    if (estimate.lost() || snapshot == nullptr) return bare;
    state::KeyResult keyed;
    {
      const StageTimer timer(stage(kKey));
      keyed = keyer.key(frame, estimate, snapshot, finder->pitch(), options.key);
      compensate::keep_off(graphics, keyed.matte);
    }
    const StageTimer timer(stage(kEncode));
    auto encoded = codec::encode(
        encode::assemble(frame, estimate, std::move(keyed.matte), finder->pitch(), options.encode),
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
    finder->from_held(held);
    note_survey();
    calibrator = finder->make_calibrator();
    std::vector<geometry::CameraEstimate> estimates;
    for (std::size_t i = 0; i < held.size(); ++i)
      estimates.push_back(calibrate_frame(*held[i], held_counts[i]));
    follow_held_back(estimates);
    start_plate(estimates, *held.front());
    for (std::size_t i = 0; i < held.size(); ++i) learn_plate(*held[i], estimates[i]);
    publish_plate(out);
    newest = held.back();
    for (std::size_t i = 0; i < held.size(); ++i) {
      out.views.push_back(encode_frame(*held[i], estimates[i], sent_plate));
      held[i].reset();
    }
    held.clear();
    held_counts.clear();
    return done(std::move(out));
  }

  // Without the graphics that are burnt into it.
  image::FramePtr blanked(image::Frame frame) const {
    if (!graphics.empty()) compensate::blank(graphics, frame);
    return std::make_shared<const image::Frame>(std::move(frame));
  }

  image::FramePtr compensated(const image::Frame& frame) {
    const StageTimer timer(stage(kCompensate));
    return blanked(compensator->apply(frame));
  }
};

FrameChain::FrameChain(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
FrameChain::FrameChain(FrameChain&&) noexcept = default;
FrameChain& FrameChain::operator=(FrameChain&&) noexcept = default;
FrameChain::~FrameChain() = default;

base::Result<FrameChain> FrameChain::make(const ChainSetup& setup, const ChainOptions& options,
                                          std::vector<image::Frame> stills,
                                          runtime::Executor* executor, head::HeadSource* head) {
  if (base::Status status = options.validate(); !status) return base::fail(status.error());
  auto impl = std::make_unique<Impl>();
  impl->setup = setup;
  impl->options = options;
  auto pitch = pitch::make_pitch(setup.sport, setup.sizes);
  if (!pitch) return base::fail(pitch.error());
  runtime::Executor& slow = executor != nullptr ? *executor : impl->at_once;
  impl->finder.emplace(setup, options.mount, std::move(*pitch), slow);
  impl->keeper.emplace(setup.camera, options.plate_file, slow);
  impl->head.emplace(head, options.head);
  impl->peers.emplace(options.peers);
  impl->stills = std::move(stills);
  impl->report.stages = {{"compensate", 0, 0}, {"survey", 0, 0}, {"calibrate", 0, 0},
                         {"plate", 0, 0},      {"key", 0, 0},    {"encode", 0, 0}};
  if (!impl->stills.empty()) impl->survey_stills();
  return FrameChain(std::move(impl));
}

void FrameChain::look_ahead(std::vector<image::FramePtr> pictures) {
  if (impl_->setup.kind != HeadKind::kHead || impl_->finder->mount() || pictures.empty()) return;
  {
    const StageTimer timer(impl_->stage(kSurvey));
    impl_->graphics = compensate::find_burnt_in(pictures, impl_->options.burnt_in);
    state::DetailModel detail;
    const auto undo =
        compensator_of(impl_->options.detail, pictures, impl_->options.detail_frames, detail);
    for (image::FramePtr& picture : pictures) picture = impl_->blanked(undo.apply(*picture));
  }
  if (const image::Rect& box = impl_->graphics.bounds; !box.empty())
    impl_->note(fmt::format("graphics burnt into the picture: masked within {} x {} at ({}, {})",
                            box.width, box.height, box.x, box.y));
  impl_->finder->from_take(pictures);
  impl_->note_survey();
}

ChainOutput FrameChain::push(image::FramePtr frame) {
  ++impl_->report.frames_in;
  const auto counts = impl_->head->read(*frame);
  if (!impl_->running) {
    impl_->held_counts.push_back(counts);
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
  impl_->newest = clean;
  impl_->follow_anew(impl_->finder->retry(clean));
  geometry::CameraEstimate estimate = impl_->calibrate_frame(*clean, counts);
  // The finder looks at lines: what encoders or texture say is nothing to it.
  const bool by_lines = estimate.evidence == geometry::Evidence::kLines;
  const MountFinder::Change change =
      impl_->finder->follow(clean, by_lines ? estimate : Impl::lost(*clean));
  impl_->follow_anew(change);
  if (change != MountFinder::Change::kNone) estimate = impl_->calibrate_frame(*clean, counts);
  if (!impl_->plate && estimate.evidence == geometry::Evidence::kLines)
    impl_->start_plate({estimate}, *clean);
  impl_->learn_plate(*clean, estimate);
  if (++impl_->frames_since_plate >=
      static_cast<std::uint64_t>(impl_->options.plate_publish_frames)) {
    impl_->publish_plate(out);
  }
  const auto snapshot = impl_->plate ? impl_->plate->snapshot() : nullptr;
  out.views.push_back(impl_->encode_frame(*clean, estimate, snapshot));
  return impl_->done(std::move(out));
}

void FrameChain::train_key(std::string_view order) {
  const auto parsed = key::parse_training_order(order);
  auto done = parsed ? key::obey(*parsed, impl_->newest.get(), impl_->options.key_colours,
                                 impl_->options.key.colours)
                     : base::fail(parsed.error());
  impl_->note(done ? std::move(*done) : base::to_string(done.error()));
}

void FrameChain::hear(PeopleSeen people) { impl_->peers->hear(std::move(people)); }

ChainOutput FrameChain::finish() {
  if (!impl_->running) return impl_->release();
  ChainOutput out;
  impl_->publish_plate(out);
  return impl_->done(std::move(out));
}

base::Status FrameChain::save_plate() { return impl_->keeper->save(impl_->plate.get()); }

ChainReport FrameChain::report() const {
  ChainReport report = impl_->report;
  const MountFinder& finder = *impl_->finder;
  report.survey_rms_px = finder.rms_px();
  report.survey_solved = finder.solved();
  report.survey_error = finder.error();
  report.stages[kSurvey].seconds += finder.time().seconds;
  report.stages[kSurvey].frames += finder.time().frames;
  return report;
}

}  // namespace touchline::edge
