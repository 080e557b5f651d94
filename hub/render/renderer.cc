#include "hub/render/renderer.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "hub/render/background_internal.h"
#include "hub/render/foreground_internal.h"
#include "hub/render/hull_surfaces_internal.h"
#include "hub/render/source_view_internal.h"
#include "hub/render/stadium_sweep_internal.h"
#include "hub/render/turf_shadow_internal.h"

namespace touchline::render {
namespace {

std::uint8_t to_byte(float v) {
  return static_cast<std::uint8_t>(std::clamp(v + 0.5f, 0.f, 255.f));
}

std::string why_unusable(const codec::CameraView& view) {
  if (view.estimate.lost()) return "its pose is lost";
  if (!view.matte) return "it has no matte";
  const geometry::CameraModel& model = view.estimate.model;
  if (model.width < 2 || model.height < 2 || view.matte->alpha.width() != model.width ||
      view.matte->alpha.height() != model.height) {
    return fmt::format("its matte is {}x{}, its camera {}x{}", view.matte->alpha.width(),
                       view.matte->alpha.height(), model.width, model.height);
  }
  return {};
}

}  // namespace

std::string_view name(Mode mode) {
  switch (mode) {
    case Mode::kRefined:
      return "refined";
    case Mode::kHull:
      return "hull";
    case Mode::kBillboard:
      return "billboard";
  }
  return "?";
}

base::Result<Mode> parse_mode(const std::string& text) {
  for (const Mode mode : {Mode::kRefined, Mode::kHull, Mode::kBillboard}) {
    if (text == name(mode)) return mode;
  }
  return base::fail(base::ErrorKind::kArgument, "mode", "'" + text + "' is no render mode",
                    "use refined, hull or billboard");
}

struct Renderer::Impl {
  BackgroundRenderer background;
  ColourReference colour;
  RenderOptions options;

  const PlateTexture* plate_of(const base::CameraId& id) const {
    for (const PlateCamera& camera : background.cameras()) {
      if (camera.id == id) return &camera.texture;
    }
    return nullptr;
  }

  std::vector<SourceView> prepare(std::span<const codec::CameraView> views,
                                  RenderReport& report) const {
    std::vector<const codec::CameraView*> usable;
    for (const codec::CameraView& view : views) {
      const std::string reason = why_unusable(view);
      if (!reason.empty()) {
        report.warnings.push_back(
            fmt::format("camera {} is not used: {}", view.id.camera.value, reason));
        continue;
      }
      if (!view.tiles) {
        report.warnings.push_back(
            fmt::format("camera {} gives no colour: it has no tiles", view.id.camera.value));
      }
      usable.push_back(&view);
    }
    std::vector<std::optional<SourceView>> made(usable.size());
    tbb::parallel_for(std::size_t{0}, usable.size(), [&](std::size_t i) {
      const base::CameraId& id = usable[i]->id.camera;
      made[i].emplace(*usable[i], colour.of(id), plate_of(id), options);
    });
    std::vector<SourceView> out;
    out.reserve(made.size());
    for (std::optional<SourceView>& view : made) out.push_back(std::move(*view));
    return out;
  }

  Foreground people(std::span<const SourceView> views, const scene::Hull& hull,
                    const geometry::CameraEstimate& camera, Mode mode, RenderReport& report) const {
    const HullSurfaces surfaces(hull);
    ForegroundScene scene{views, hull, surfaces, billboard_cards(views, hull), true};
    const std::size_t billboards = scene.cards.size();
    if (mode == Mode::kBillboard) {
      scene.show_hull = false;
      for (Card& card : group_cards(views, hull, geometry::position_in_world(camera))) {
        scene.cards.push_back(card);
      }
    }
    if (mode == Mode::kRefined) {
      report.warnings.push_back("refined layers are not available: groups are shown as hull");
    }
    Foreground out = render::render_foreground(scene, background.pitch(), camera, options);
    for (std::size_t g = 0; g < hull.groups.size(); ++g) {
      bool shown = out.group_cover[g] > 0;
      scene::Rendition rendition = scene::Rendition::kHull;
      for (std::size_t c = billboards; c < scene.cards.size(); ++c) {
        if (scene.cards[c].group == static_cast<int>(g) && out.card_cover[c] > 0) {
          shown = true;
          rendition = scene::Rendition::kBillboard;
        }
      }
      report.groups.push_back({hull.groups[g].id, shown ? rendition : scene::Rendition::kAbsent});
    }
    for (const scene::Billboard& billboard : hull.billboards) {
      bool shown = false;
      for (std::size_t c = 0; c < billboards; ++c) {
        shown = shown || (scene.cards[c].id == billboard.id && out.card_cover[c] > 0);
      }
      report.groups.push_back(
          {billboard.id, shown ? scene::Rendition::kBillboard : scene::Rendition::kAbsent});
    }
    for (std::size_t i = 0; i < views.size(); ++i) {
      if (out.share[i] > 0) report.share_by_camera[views[i].id()] += out.share[i];
    }
    double covered = 0;
    for (std::size_t i = 0; i < out.coverage.size(); ++i) {
      covered += static_cast<double>(out.coverage.data()[i]);
    }
    report.foreground_share =
        covered / static_cast<double>(std::max<std::size_t>(1, out.coverage.size()));
    return out;
  }
};

Renderer::Renderer(std::unique_ptr<const Impl> impl) : impl_(std::move(impl)) {}
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;
Renderer::~Renderer() = default;

base::Result<Renderer> Renderer::make(const pitch::PitchModel& pitch,
                                      const std::map<base::CameraId, image::PlateSnapshot>& plates,
                                      const ColourReference& colour, const RenderOptions& options) {
  if (auto status = options.validate(); !status) return base::fail(status.error());
  std::vector<PlateCamera> cameras;
  for (const auto& [id, plate] : plates) {
    if (plate.tiles.empty() || !(plate.radians_per_px > 0)) continue;
    cameras.push_back({id, PlateTexture(plate, colour.of(id))});
  }
  Stadium stadium = options.find_stadium ? sweep_stadium(pitch, cameras, options.stadium)
                                         : default_stadium(pitch, options.stadium);
  return Renderer(std::make_unique<const Impl>(
      Impl{BackgroundRenderer(pitch, std::move(stadium), std::move(cameras), options), colour,
           options}));
}

const Stadium& Renderer::stadium() const { return impl_->background.stadium(); }

RenderResult Renderer::render(std::span<const codec::CameraView> views, const scene::Hull& hull,
                              const geometry::CameraEstimate& camera, Mode mode) const {
  RenderResult out;
  const std::vector<SourceView> sources = impl_->prepare(views, out.report);
  const Foreground people = impl_->people(sources, hull, camera, mode, out.report);
  Background ground = impl_->background.render(camera);
  if (impl_->options.shadows) {
    cast_shadows(sources, impl_->background.pitch(), camera, impl_->options.angle_scale_deg,
                 ground);
  }
  out.picture = scene::Picture(camera.model.width, camera.model.height);
  double unseen = 0;
  for (std::size_t i = 0; i < out.picture.size(); ++i) {
    const float open = 1 - people.coverage.data()[i];
    Eigen::Vector3f& colour = ground.colour.data()[i];
    colour = people.colour.data()[i] + open * colour;
    float& distance = ground.distance.data()[i];
    distance = std::min(distance, people.distance.data()[i]);
    unseen += static_cast<double>(open * (1 - ground.seen.data()[i]));
  }
  impl_->background.goals().paint(camera, impl_->background.cameras(), ground.distance,
                                  ground.colour);
  for (std::size_t i = 0; i < out.picture.size(); ++i) {
    const Eigen::Vector3f& colour = ground.colour.data()[i];
    out.picture.data()[i] = {to_byte(colour[0]), to_byte(colour[1]), to_byte(colour[2]), 255};
  }
  out.report.unseen_share =
      unseen / static_cast<double>(std::max<std::size_t>(1, out.picture.size()));
  // What the plates show fills the rest of the picture.
  double plates = 0;
  for (const double share : ground.share) plates += share;
  const double rest = std::max(0.0, 1 - out.report.foreground_share - out.report.unseen_share);
  for (std::size_t i = 0; i < ground.share.size(); ++i) {
    if (ground.share[i] <= 0 || plates <= 0) continue;
    out.report.share_by_camera[impl_->background.cameras()[i].id] +=
        rest * ground.share[i] / plates;
  }
  return out;
}

RenderResult Renderer::render_foreground(std::span<const codec::CameraView> views,
                                         const scene::Hull& hull,
                                         const geometry::CameraEstimate& camera, Mode mode) const {
  RenderResult out;
  const std::vector<SourceView> sources = impl_->prepare(views, out.report);
  const Foreground people = impl_->people(sources, hull, camera, mode, out.report);
  out.picture = scene::Picture(camera.model.width, camera.model.height);
  for (std::size_t i = 0; i < out.picture.size(); ++i) {
    const float coverage = people.coverage.data()[i];
    const std::uint8_t a = to_byte(255 * coverage);
    if (a == 0) continue;
    const Eigen::Vector3f colour = people.colour.data()[i] / coverage;
    out.picture.data()[i] = {to_byte(colour[0]), to_byte(colour[1]), to_byte(colour[2]), a};
  }
  return out;
}

}  // namespace touchline::render
