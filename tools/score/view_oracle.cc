#include "tools/score/view_oracle.h"

#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "edge/compensate/compensator.h"
#include "edge/compensate/detail_estimator.h"
#include "edge/plate/plate_builder.h"
#include "hub/hull/carve.h"
#include "hub/render/renderer.h"
#include "shared/recording/camera_table.h"
#include "shared/recording/still_reader.h"
#include "shared/recording/video_reader.h"
#include "tools/score/oracle.h"

namespace touchline::score {

namespace {

constexpr std::int64_t kDetailFrames = 6;
constexpr std::int64_t kPlateFrames = 100;

// What is learnt of a camera before the first picture.
struct Learnt {
  base::Status status;
  state::DetailModel detail;
  std::optional<image::PlateSnapshot> plate;
};

// Survey stills with their true cameras, where the truth has them.
base::Status seed(plate::PlateBuilder& builder, const compensate::Compensator& compensator,
                  const recording::CameraEntry& entry, const Truth& truth) {
  const auto table = truth.root() / entry.id.value / "survey.csv";
  std::error_code error;
  if (entry.survey.empty() || !std::filesystem::exists(table, error)) return {};
  const auto rows = recording::read_camera_table(table);
  if (!rows) return base::fail(rows.error());
  const auto stills = recording::survey_stills(entry);
  if (!stills) return base::fail(stills.error());
  for (const recording::CameraRow& row : *rows) {
    const auto number = static_cast<std::size_t>(row.frame);
    if (row.frame < 0 || number >= stills->size()) continue;
    const auto still = recording::read_still((*stills)[number]);
    if (!still) return base::fail(still.error());
    geometry::CameraEstimate camera;
    camera.model = row.model;
    camera.model.width = still->width();
    camera.model.height = still->height();
    camera.cam_from_world = row.cam_from_world;
    camera.evidence = geometry::Evidence::kLines;
    builder.seed(compensator.apply(*still), camera);
  }
  return {};
}

Learnt learn(const recording::CameraEntry& entry, const recording::Recording& recording,
             const Truth& truth, const pitch::PitchModel& pitch) {
  Learnt learnt;
  const std::vector<std::int64_t> frames = truth.camera_frames(entry.id);
  if (frames.empty()) return learnt;
  double focal = 0;
  for (const std::int64_t frame : frames) {
    focal = std::max(focal, truth.camera(entry.id, frame)->model.fx);
  }
  plate::PlateBuilder builder(
      pitch, geometry::position_in_world(*truth.camera(entry.id, frames.front())), 1 / focal);
  auto reader = recording::VideoReader::open(entry, recording, 0);
  if (!reader) {
    learnt.status = base::fail(reader.error());
    return learnt;
  }
  // The first frames tell the detail setting, then all of them teach the plate.
  compensate::DetailEstimator estimator;
  std::vector<image::Frame> held;
  std::optional<compensate::Compensator> compensator;
  for (std::int64_t k = 0; k < kPlateFrames; ++k) {
    auto frame = reader->next();
    if (!frame) {
      learnt.status = base::fail(frame.error());
      return learnt;
    }
    if (k < kDetailFrames && *frame) {
      estimator.add((*frame)->luma());
      held.push_back(std::move(**frame));
      continue;
    }
    if (!compensator) {
      learnt.detail = estimator.estimate();
      compensator.emplace(learnt.detail);
      learnt.status = seed(builder, *compensator, entry, truth);
      if (!learnt.status) return learnt;
      for (std::size_t i = 0; i < held.size(); ++i) {
        const auto camera = truth.camera(entry.id, static_cast<std::int64_t>(i));
        if (camera) builder.add(compensator->apply(held[i]), *camera);
      }
      held.clear();
    }
    if (!*frame) break;
    const auto camera = truth.camera(entry.id, k);
    if (camera) builder.add(compensator->apply(**frame), *camera);
  }
  if (const auto snapshot = builder.snapshot(true)) learnt.plate = *snapshot;
  return learnt;
}

}  // namespace

struct ViewOracle::Impl {
  Oracle views;
  render::Renderer renderer;
  double voxel_m = 0.02;
};

ViewOracle::ViewOracle(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ViewOracle::ViewOracle(ViewOracle&&) noexcept = default;
ViewOracle& ViewOracle::operator=(ViewOracle&&) noexcept = default;
ViewOracle::~ViewOracle() = default;

base::Result<ViewOracle> ViewOracle::open(const recording::Recording& recording, const Truth& truth,
                                          double voxel_m) {
  const auto pitch = pitch::make_pitch(recording.sport, recording.sizes);
  if (!pitch) return base::fail(pitch.error());
  std::vector<Learnt> learnt(recording.cameras.size());
  tbb::parallel_for(std::size_t{0}, learnt.size(), [&](std::size_t i) {
    learnt[i] = learn(recording.cameras[i], recording, truth, *pitch);
  });
  std::map<base::CameraId, image::PlateSnapshot> plates;
  auto compensators = std::make_shared<std::map<base::CameraId, compensate::Compensator>>();
  for (std::size_t i = 0; i < learnt.size(); ++i) {
    if (!learnt[i].status) return base::fail(learnt[i].status.error());
    const base::CameraId& id = recording.cameras[i].id;
    compensators->emplace(id, compensate::Compensator(learnt[i].detail));
    if (learnt[i].plate) plates[id] = std::move(*learnt[i].plate);
  }
  OracleOptions options;
  options.treat = [compensators](const base::CameraId& camera, const image::Frame& frame) {
    return compensators->at(camera).apply(frame);
  };
  auto views = Oracle::open(recording, truth, options);
  if (!views) return base::fail(views.error());
  const auto colour = render::estimate_colour_reference(*pitch, plates);
  auto renderer = render::Renderer::make(*pitch, plates, colour);
  if (!renderer) return base::fail(renderer.error());
  return ViewOracle(std::unique_ptr<Impl>(
      new Impl{std::move(*views), std::move(*renderer), std::clamp(voxel_m, 0.005, 0.2)}));
}

base::Result<std::vector<RenderedView>> ViewOracle::render(
    std::int64_t instant, const std::vector<geometry::CameraEstimate>& cameras) {
  impl_->views.skip_to(instant);
  const auto views = impl_->views.next();
  if (!views) return base::fail(views.error());
  if (!*views) {
    return base::fail(base::ErrorKind::kNotFound, fmt::format("instant {}", instant),
                      "no video and truth of it", "score with --no-oracle");
  }
  hull::HullOptions options;
  options.voxel_m = impl_->voxel_m;
  const scene::Hull hull = hull::carve(**views, impl_->views.pitch(), options).hull;
  std::vector<RenderedView> out;
  for (const geometry::CameraEstimate& camera : cameras) {
    RenderedView view;
    view.picture =
        scene::opaque(impl_->renderer.render(**views, hull, camera, render::Mode::kHull).picture);
    const scene::Picture alone =
        impl_->renderer.render_foreground(**views, hull, camera, render::Mode::kHull).picture;
    view.foreground = Mask(alone.width(), alone.height());
    for (std::size_t i = 0; i < alone.size(); ++i) view.foreground.data()[i] = alone.data()[i].a;
    out.push_back(std::move(view));
  }
  return out;
}

}  // namespace touchline::score
