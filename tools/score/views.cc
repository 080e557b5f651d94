// The views of virtual cameras: what was exported, and beside it the oracle.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "tools/score/body_map.h"
#include "tools/score/score_context.h"
#include "tools/score/view_oracle.h"
#include "tools/score/view_score.h"

namespace touchline::score {

namespace {

const ScoreKind kPsnr{"views", "PSNR of people", "dB", Better::kHigher, Statistic::kMean, 2};
const ScoreKind kSsim{"views", "SSIM of people", "", Better::kHigher, Statistic::kMean, 4};
const ScoreKind kShift{"views", "misalignment", "px", Better::kLower, Statistic::kMean, 2};
const ScoreKind kAligned{"views", "PSNR aligned", "dB", Better::kHigher, Statistic::kMean, 2};
const ScoreKind kMissing{"views", "missing foreground", "%", Better::kLower, Statistic::kMean, 2};
const ScoreKind kPhantom{"views", "phantom foreground", "%", Better::kLower, Statistic::kMean, 2};
const ScoreKind kLimbs{"views", "limb recall", "%", Better::kHigher, Statistic::kMean, 2};
const ScoreKind kLimbsOf{"views",         "limb recall by person", "%",
                         Better::kHigher, Statistic::kMean,        2};
const ScoreKind kMissingOf{"views", "missing by person", "%", Better::kLower, Statistic::kMean, 2};
const ScoreKind kPsnrOf{"views", "PSNR by person", "dB", Better::kHigher, Statistic::kMean, 2};
const ScoreKind kFlicker{"views", "flicker", "", Better::kLower, Statistic::kMean, 3};
const ScoreKind kFullPsnr{"views",         "PSNR, full picture", "dB",
                          Better::kHigher, Statistic::kMean,     2};
const ScoreKind kFullSsim{"views", "SSIM, full picture", "", Better::kHigher, Statistic::kMean, 4};

// What is true of one picture.
struct TrueView {
  std::int64_t frame = 0;
  geometry::CameraEstimate camera;
  Picture clean;
  std::optional<Mask> matte;
  Mask people;  // where people are looked at: all of it without a matte
};

struct ShownView {
  Picture picture;
  std::optional<Mask> foreground;
};

// The picture before, for flicker.
struct Before {
  Picture clean;
  Mask people;
  Picture picture;
};

void score_people_of(const Context& context, const TrueView& truth, const ShownView& shown,
                     const std::string& id, SeriesBook& book) {
  const std::vector<TruePerson>& people = context.truth.people(truth.frame);
  const std::vector<TrueJoint>& joints = context.truth.joints(truth.frame);
  if (people.empty()) return;
  const auto owner = body_map(*truth.matte, truth.camera, people, joints);
  struct Sums {
    double squares = 0, pixels = 0, missing = 0, limb = 0, limb_found = 0;
  };
  std::vector<Sums> sums(people.size());
  const auto limbs = limb_map(*truth.matte, truth.camera, people, joints);
  for (std::size_t i = 0; i < owner.size(); ++i) {
    const bool found = shown.foreground && shown.foreground->data()[i] >= 128;
    if (const std::uint8_t p = owner.data()[i]; p != kNobody) {
      const image::Rgb8& a = truth.clean.data()[i];
      const image::Rgb8& b = shown.picture.data()[i];
      const double r = a.r - b.r, g = a.g - b.g, l = a.b - b.b;
      sums[p].squares += r * r + g * g + l * l;
      ++sums[p].pixels;
      sums[p].missing += !found;
    }
    if (const std::uint8_t p = limbs.data()[i]; p != kNobody) {
      ++sums[p].limb;
      sums[p].limb_found += found;
    }
  }
  double limb = 0, limb_found = 0;
  constexpr double kLeastPixels = 50;
  for (std::size_t p = 0; p < people.size(); ++p) {
    const Sums& s = sums[p];
    limb += s.limb;
    limb_found += s.limb_found;
    if (s.pixels >= kLeastPixels) {
      const double mean = s.squares / (3 * s.pixels);
      const double psnr = mean > 0 ? std::min(99.0, 10 * std::log10(255.0 * 255.0 / mean)) : 99;
      book.add_person(kPsnrOf, people[p].id, {truth.frame, psnr});
      if (shown.foreground) {
        book.add_person(kMissingOf, people[p].id,
                        {truth.frame, 100 * s.missing / s.pixels, s.pixels});
      }
    }
    if (shown.foreground && s.limb > 0) {
      book.add_person(kLimbsOf, people[p].id, {truth.frame, 100 * s.limb_found / s.limb, s.limb});
    }
  }
  if (shown.foreground && limb > 0) {
    book.add(kLimbs, id, {truth.frame, 100 * limb_found / limb, limb});
  }
}

void score_one(const Context& context, const TrueView& truth, ShownView shown,
               const std::string& id, std::optional<Before>& before, SeriesBook& book) {
  const std::int64_t frame = truth.frame;
  const bool anybody = std::any_of(truth.people.data(), truth.people.data() + truth.people.size(),
                                   [](std::uint8_t v) { return v != 0; });
  const Similarity similar = ssim(truth.clean, shown.picture, truth.people);
  if (truth.matte && anybody) {
    book.add(kPsnr, id, {frame, psnr_db(truth.clean, shown.picture, truth.people)});
    book.add(kSsim, id, {frame, similar.inside});
    const Alignment aligned = align(truth.clean, shown.picture, truth.people);
    for (const PieceShift& piece : aligned.pieces) {
      book.add(kShift, id, {frame, piece.shift_px.norm(), piece.pixels});
    }
    if (!aligned.pieces.empty()) book.add(kAligned, id, {frame, aligned.psnr_db});
    if (shown.foreground) {
      const ForegroundCount count = count_foreground(*truth.matte, *shown.foreground);
      if (count.truth > 0) {
        book.add(kMissing, id, {frame, 100 * count.missing / count.truth, count.truth});
        book.add(kPhantom, id, {frame, 100 * count.phantom / count.truth, count.truth});
      }
    }
    score_people_of(context, truth, shown, id, book);
    if (before) {
      Mask either = truth.people;
      for (std::size_t i = 0; i < either.size(); ++i) either.data()[i] |= before->people.data()[i];
      const Flicker change =
          flicker(before->clean, before->picture, truth.clean, shown.picture, either);
      if (change.clean_change > 0) {
        book.add(kFlicker, id,
                 {frame, change.error_change / change.clean_change, change.clean_change});
      }
    }
  }
  const Mask everywhere(truth.clean.width(), truth.clean.height(), 255);
  book.add(kFullPsnr, id, {frame, psnr_db(truth.clean, shown.picture, everywhere)});
  book.add(kFullSsim, id, {frame, similar.full});
  before = Before{truth.clean, truth.people, std::move(shown.picture)};
}

base::Status same_size(const std::filesystem::path& path, int width, int height,
                       const Picture& clean) {
  if (width == clean.width() && height == clean.height()) return {};
  return base::fail(base::ErrorKind::kFormat, path.string(),
                    fmt::format("is {} x {}, the clean picture {} x {}", width, height,
                                clean.width(), clean.height()),
                    "render without --size");
}

base::Result<TrueView> read_truth(const Context& context, const base::CameraId& id,
                                  std::int64_t frame) {
  TrueView view;
  view.frame = frame;
  auto clean = context.truth.clean(id, frame);
  if (!clean) return base::fail(clean.error());
  view.clean = std::move(*clean);
  const auto camera = context.truth.camera(id, frame);
  if (!camera) {
    return base::fail(base::ErrorKind::kFormat, (context.truth.root() / id.value).string(),
                      fmt::format("has a clean picture and no camera of frame {}", frame),
                      "complete cameras.csv");
  }
  view.camera = *camera;
  view.camera.model.width = view.clean.width();
  view.camera.model.height = view.clean.height();
  auto matte = context.truth.matte(id, frame);
  if (matte) {
    const auto path = numbered(context.truth.root() / id.value / "matte", frame, ".png");
    const auto status = same_size(path, matte->width(), matte->height(), view.clean);
    if (!status) return base::fail(status.error());
    view.people = grown_foreground(*matte);
    view.matte = std::move(*matte);
  } else if (matte.error().kind == base::ErrorKind::kNotFound) {
    view.people = Mask(view.clean.width(), view.clean.height(), 255);
  } else {
    return base::fail(matte.error());
  }
  return view;
}

base::Result<ShownView> read_shown(const Context& context, const base::CameraId& id,
                                   const TrueView& truth) {
  ShownView shown;
  const auto path = numbered(context.options.exports / "renders" / id.value, truth.frame, ".png");
  auto picture = read_rgb_png(path);
  if (!picture) return base::fail(picture.error());
  auto status = same_size(path, picture->width(), picture->height(), truth.clean);
  if (!status) return base::fail(status.error());
  shown.picture = std::move(*picture);
  const auto alone =
      numbered(context.options.exports / "foreground" / id.value, truth.frame, ".png");
  if (!is_there(alone)) return shown;
  auto alpha = read_alpha_png(alone);
  if (!alpha) return base::fail(alpha.error());
  status = same_size(alone, alpha->width(), alpha->height(), truth.clean);
  if (!status) return base::fail(status.error());
  shown.foreground = std::move(*alpha);
  return shown;
}

struct Camera {
  base::CameraId id;
  std::set<std::int64_t> frames;
  std::optional<Before> before;
  std::optional<Before> oracle_before;
};

// Frames that flicker is told over.
void note_steps(const std::vector<Camera>& cameras, Remarks& remarks) {
  for (const Camera& camera : cameras) {
    std::int64_t most = 0;
    std::optional<std::int64_t> last;
    for (const std::int64_t frame : camera.frames) {
      if (last) most = std::max(most, frame - *last);
      last = frame;
    }
    if (most > 1) {
      remarks.notes.push_back(fmt::format(
          "flicker of {}: the truth has clean pictures up to {} frames apart, changes are told "
          "between those",
          camera.id.value, most));
    }
  }
}

std::vector<Camera> cameras_to_score(const Context& context, Remarks& remarks) {
  std::vector<Camera> cameras;
  const ScoreOptions& options = context.options;
  if (context.truth.virtual_cameras().empty()) {
    remarks.not_scored.push_back("views: the truth has no virtual camera");
  }
  for (const base::CameraId& id : context.truth.virtual_cameras()) {
    const auto folder = options.exports / "renders" / id.value;
    std::vector<std::int64_t> frames = context.truth.clean_frames(id);
    if (frames.empty()) {
      remarks.not_scored.push_back(
          fmt::format("view {}: the truth has no clean picture", id.value));
      continue;
    }
    if (!is_there(folder)) {
      remarks.not_scored.push_back(fmt::format("view {}: no {}", id.value, folder.string()));
      continue;
    }
    const std::size_t all = frames.size();
    std::erase_if(frames, [&](std::int64_t f) { return !is_there(numbered(folder, f, ".png")); });
    if (frames.size() < all) {
      remarks.not_scored.push_back(fmt::format("view {}: {} of {} clean pictures were not rendered",
                                               id.value, all - frames.size(), all));
    }
    frames = spread(frames, options.most_views);
    if (!is_there(options.exports / "foreground" / id.value)) {
      remarks.not_scored.push_back(
          fmt::format("missing and phantom foreground, limbs of {}: no {}", id.value,
                      (options.exports / "foreground" / id.value).string()));
    }
    if (context.truth.matte_frames(id).empty()) {
      remarks.not_scored.push_back(fmt::format("people in {}: the truth has no mattes", id.value));
    }
    if (!frames.empty()) cameras.push_back({id, {frames.begin(), frames.end()}, {}, {}});
  }
  return cameras;
}

}  // namespace

base::Status score_views(const Context& context, SeriesBook& book, SeriesBook& oracle,
                         Remarks& remarks) {
  std::vector<Camera> cameras = cameras_to_score(context, remarks);
  if (cameras.empty()) return {};
  note_steps(cameras, remarks);
  std::optional<ViewOracle> renderer;
  if (context.options.oracle) {
    auto opened = ViewOracle::open(context.recording, context.truth, context.options.voxel_m);
    if (!opened) return base::fail(opened.error());
    renderer.emplace(std::move(*opened));
  } else {
    remarks.not_scored.push_back("oracle of the views: switched off");
  }
  std::set<std::int64_t> instants;
  for (const Camera& camera : cameras) instants.insert(camera.frames.begin(), camera.frames.end());
  for (const std::int64_t instant : instants) {
    std::vector<Camera*> shown_now;
    std::vector<TrueView> truths;
    std::vector<geometry::CameraEstimate> models;
    for (Camera& camera : cameras) {
      if (!camera.frames.count(instant)) continue;
      auto truth = read_truth(context, camera.id, instant);
      if (!truth) return base::fail(truth.error());
      auto shown = read_shown(context, camera.id, *truth);
      if (!shown) return base::fail(shown.error());
      score_one(context, *truth, std::move(*shown), camera.id.value, camera.before, book);
      models.push_back(truth->camera);
      truths.push_back(std::move(*truth));
      shown_now.push_back(&camera);
    }
    if (!renderer) continue;
    auto rendered = renderer->render(instant, models);
    if (!rendered) return base::fail(rendered.error());
    for (std::size_t i = 0; i < truths.size(); ++i) {
      RenderedView& view = (*rendered)[i];
      score_one(context, truths[i], {std::move(view.picture), std::move(view.foreground)},
                shown_now[i]->id.value, shown_now[i]->oracle_before, oracle);
    }
  }
  return {};
}

}  // namespace touchline::score
