#include "tools/score/sets/multiview_wd2_person.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "edge/key/key.h"
#include "hub/hull/carve.h"
#include "hub/render/renderer.h"
#include "tools/draw/canvas.h"
#include "tools/score/page/hull_map.h"
#include "tools/score/page/view_map.h"
#include "tools/score/series.h"
#include "tools/score/sets/set_pictures.h"
#include "tools/score/sets/wd2_rig.h"
#include "tools/score/view_score.h"

namespace touchline::score {

namespace fs = std::filesystem;

namespace {

using Grey = image::Image<std::uint8_t>;
using Rgb = image::Image<image::Rgb8>;

constexpr double kHeight = 1.65;      // metres, of a person of whom nobody knows it
constexpr double kRayStep = 0.01;     // metres, of the rays that are the hull's measure
constexpr double kBelowFloor = 0.04;  // metres; as the hull's
constexpr double kTallest = 2.8;
constexpr int kRayStride = 2;      // pixels
constexpr double kRayReach = 1.3;  // metres before and behind the person's middle
constexpr std::size_t kShown = 2;  // pictures of renderings

struct Overlap {
  double both = 0, truth = 0, found = 0;
  void add(bool t, bool f) {
    both += t && f;
    truth += t;
    found += f;
  }
  double iou() const {
    const double either = truth + found - both;
    return either > 0 ? both / either : std::numeric_limits<double>::quiet_NaN();
  }
  double missing() const { return truth > 0 ? 1 - both / truth : 0; }
  double extra() const { return truth > 0 ? (found - both) / truth : 0; }
};

Overlap overlap(const Grey& truth, const Grey& found) {
  Overlap out;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    out.add(truth.data()[i] >= 128, found.data()[i] >= 128);
  }
  return out;
}

// A figure over the left-out cameras.
struct Column {
  std::string name;
  std::string unit;
  std::vector<double> values;
  SetCell mean() const {
    double sum = 0;
    for (const double v : values) sum += v;
    const double n = static_cast<double>(values.size());
    return {name, n > 0 ? sum / n : std::numeric_limits<double>::quiet_NaN(), unit, values.size()};
  }
  SetCell least() const {
    const auto at = std::min_element(values.begin(), values.end());
    return {"least " + name, at == values.end() ? std::numeric_limits<double>::quiet_NaN() : *at,
            unit, values.size()};
  }
};

struct SilhouetteColumns {
  Column iou{"IoU", "%", {}}, missing{"missing", "%", {}}, extra{"extra", "%", {}};
  void add(const Overlap& o) {
    iou.values.push_back(100 * o.iou());
    missing.values.push_back(100 * o.missing());
    extra.values.push_back(100 * o.extra());
  }
  SetRow row(std::string label) const {
    return {std::move(label), {iou.mean(), iou.least(), missing.mean(), extra.mean()}};
  }
};

std::vector<codec::CameraView> views_without(const Wd2Rig& rig, std::size_t left_out) {
  std::vector<codec::CameraView> out;
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    if (i != left_out) out.push_back(rig.cameras[i].view);
  }
  return out;
}

Grey hull_silhouette(const scene::Hull& hull, const geometry::CameraEstimate& camera) {
  const image::Rect all{0, 0, camera.model.width, camera.model.height};
  Grey out(all.width, all.height);
  for (const scene::HullGroup& group : hull.groups) {
    if (group.phantom) continue;
    const Grey one = page::silhouette(group.surface, camera, all, 1);
    for (std::size_t i = 0; i < out.size(); ++i) out.data()[i] |= one.data()[i];
  }
  return out;
}

// The visual hull itself, without voxels: a pixel is inside when its ray meets the cones of all
// other masks at once, tried every centimetre.
Overlap by_rays(const Wd2Rig& rig, std::size_t left_out) {
  const Wd2Camera& own = rig.cameras[left_out];
  Overlap out;
  const Eigen::Vector3d eye = geometry::position_in_world(own.estimate);
  const double middle = (Eigen::Vector3d(0, 0, kHeight / 2) - eye).norm();
  for (int y = 0; y < own.mask.height(); y += kRayStride) {
    for (int x = 0; x < own.mask.width(); x += kRayStride) {
      const Eigen::Vector3d ray = geometry::ray_in_world(own.estimate, Eigen::Vector2d(x, y));
      // Rays that pass the person by more than its reach meet nothing.
      const Eigen::Vector3d nearest = eye + middle * ray;
      bool inside = false;
      if (nearest.head<2>().norm() < kRayReach) {
        for (double d = middle - kRayReach; d <= middle + kRayReach && !inside; d += kRayStep) {
          const Eigen::Vector3d point = eye + d * ray;
          inside = point.z() > -kBelowFloor && point.z() < kTallest;
          int support = 0;
          for (std::size_t i = 0; i < rig.cameras.size() && inside; ++i) {
            if (i == left_out) continue;
            const auto pixel = geometry::project(rig.cameras[i].estimate, point);
            if (!pixel || !rig.cameras[i].estimate.model.sees(*pixel)) continue;
            const Grey& mask = rig.cameras[i].mask;
            const int u =
                std::clamp(static_cast<int>(std::lround(pixel->x())), 0, mask.width() - 1);
            const int v =
                std::clamp(static_cast<int>(std::lround(pixel->y())), 0, mask.height() - 1);
            inside = mask(u, v) >= 128;
            support += inside;
          }
          inside = inside && support >= 2;
        }
      }
      out.add(own.mask(x, y) >= 128, inside);
    }
  }
  return out;
}

image::Rgb8 mean_outside(const Rgb& picture, const Grey& mask) {
  std::array<double, 3> sum{};
  double n = 0;
  for (std::size_t i = 0; i < picture.size(); ++i) {
    if (mask.data()[i] >= 128) continue;
    const image::Rgb8 p = picture.data()[i];
    sum[0] += p.r;
    sum[1] += p.g;
    sum[2] += p.b;
    n += 1;
  }
  const auto one = [&](double s) {
    return static_cast<std::uint8_t>(n > 0 ? std::lround(s / n) : 0);
  };
  return {one(sum[0]), one(sum[1]), one(sum[2])};
}

// The person alone before one colour: as photographed, and as rendered.
Rgb cut_out(const Rgb& picture, const Grey& mask, image::Rgb8 ground) {
  Rgb out(picture.width(), picture.height(), ground);
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (mask.data()[i] >= 128) out.data()[i] = picture.data()[i];
  }
  return out;
}
Rgb over(const scene::Picture& rendered, image::Rgb8 ground) {
  Rgb out(rendered.width(), rendered.height(), ground);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const scene::Rgba8& p = rendered.data()[i];
    out.data()[i] = draw::mix(ground, {p.r, p.g, p.b}, p.a / 255.0);
  }
  return out;
}
Grey coverage(const scene::Picture& rendered) {
  Grey out(rendered.width(), rendered.height());
  for (std::size_t i = 0; i < out.size(); ++i) out.data()[i] = rendered.data()[i].a;
  return out;
}

struct ViewColumns {
  Column inside{"PSNR inside", "dB", {}}, people{"PSNR people", "dB", {}}, ssim_{"SSIM", "", {}};
  SilhouetteColumns shape;
  void add(const Rgb& clean, const Rgb& ours, const Grey& mask, const Grey& found) {
    const Grey grown = grown_foreground(mask);
    inside.values.push_back(psnr_db(clean, ours, mask));
    people.values.push_back(psnr_db(clean, ours, grown));
    ssim_.values.push_back(ssim(clean, ours, grown).inside);
    shape.add(overlap(mask, found));
  }
  SetRow row(std::string label) const {
    return {std::move(label),
            {shape.iou.mean(), shape.iou.least(), shape.missing.mean(), shape.extra.mean(),
             inside.mean(), inside.least(), people.mean(), ssim_.mean()}};
  }
};

// Keyed by the floor's colour alone: there is no plate.
Overlap keyed(const Wd2Rig& rig, const Wd2Camera& camera) {
  const image::PlateSnapshot nothing;
  key::KeyOptions options;
  options.margin_m = 0;
  const auto result = key::key(camera.frame, camera.estimate, nothing, rig.floor, options);
  return overlap(camera.mask, result.matte.alpha);
}

}  // namespace

base::Result<SetReport> run_multiview_wd2_person(const SetOptions& options) {
  const fs::path folder = options.data / "multiview-wd2-person";
  if (!fs::is_directory(folder)) {
    return base::fail(base::ErrorKind::kNotFound, folder.string(), "is not there",
                      "set TOUCHLINE_DATA or give --data");
  }
  const auto rig = load_wd2_rig(folder, kHeight);
  if (!rig) return base::fail(rig.error());
  auto renderer = render::Renderer::make(rig->floor, {}, {});
  if (!renderer) return base::fail(renderer.error());

  struct Carving {
    std::string label;
    hull::HullOptions options;
    SilhouetteColumns columns;
  };
  std::vector<Carving> carvings(3);
  carvings[0].label = "hull of the others, as in the product (2 cm, 3 px)";
  carvings[1].label = "hull of the others, 2 cm, 1 px";
  carvings[1].options.dilation_px = 1;
  carvings[2].label = "hull of the others, 1 cm, 0 px";
  carvings[2].options.dilation_px = 0;
  carvings[2].options.voxel_m = 0.01;
  for (Carving& carving : carvings) carving.options.margin_m = 0;
  const std::vector<codec::CameraView> all = views_without(*rig, rig->cameras.size());
  const scene::Hull of_all = hull::carve(all, rig->floor, carvings[0].options).hull;
  SilhouetteColumns exact;
  SilhouetteColumns key_alone;
  ViewColumns shown, card, kept;

  SetReport report;
  report.name = "multiview-wd2-person";
  report.what = fmt::format(
      "One person on a green floor, {} calibrated cameras about {:.1f} m away, {} x {}, masks "
      "given; each camera is left out in turn, figures are means over them.",
      rig->cameras.size(), rig->camera_distance_m, rig->cameras[0].mask.width(),
      rig->cameras[0].mask.height());
  for (std::size_t i = 0; i < rig->cameras.size(); ++i) {
    const Wd2Camera& own = rig->cameras[i];
    const std::vector<codec::CameraView> others = views_without(*rig, i);
    scene::Hull product;
    for (Carving& carving : carvings) {
      hull::HullResult result = hull::carve(others, rig->floor, carving.options);
      carving.columns.add(overlap(own.mask, hull_silhouette(result.hull, own.estimate)));
      if (&carving == &carvings.front()) product = std::move(result.hull);
    }
    exact.add(by_rays(*rig, i));
    key_alone.add(keyed(*rig, own));

    const image::Rgb8 ground = mean_outside(own.picture, own.mask);
    const Rgb clean = cut_out(own.picture, own.mask, ground);
    const auto render = [&](std::span<const codec::CameraView> views, const scene::Hull& hull,
                            render::Mode mode, ViewColumns& columns) {
      const auto rendered = renderer->render_foreground(views, hull, own.estimate, mode).picture;
      Rgb ours = over(rendered, ground);
      columns.add(clean, ours, own.mask, coverage(rendered));
      return ours;
    };
    const Rgb ours = render(others, product, render::Mode::kHull, shown);
    render(others, product, render::Mode::kBillboard, card);
    render(all, of_all, render::Mode::kHull, kept);
    if (!options.pictures.empty() &&
        i % std::max<std::size_t>(1, rig->cameras.size() / kShown) == 0) {
      const auto written =
          write_rgb(options.pictures / fmt::format("{}-{:02}.png", report.name, own.number),
                    page::view_map(clean, ours, own.mask, page::window_round_mask(own.mask)).zoom);
      if (!written) return base::fail(written.error());
    }
  }
  for (const Carving& carving : carvings) report.rows.push_back(carving.columns.row(carving.label));
  report.rows.push_back(exact.row("peer: the visual hull itself, by rays (1 cm, no voxels)"));
  report.rows.push_back(shown.row("view from the others: our hull mode"));
  report.rows.push_back(card.row("peer: billboard mode (one card, nearest camera)"));
  report.rows.push_back(kept.row("ceiling: our hull mode, own camera among them"));
  report.rows.push_back(key_alone.row("our key without a plate, by the floor's colour"));
  report.notes = {
      "IoU, missing and extra of the left-out camera's given mask; missing and extra by its size.",
      "PSNR inside: within the mask; PSNR people and SSIM: within the mask grown by 8 px, both "
      "pictures cut out before the picture's mean colour.",
      fmt::format("The set has no unit and no floor: the person counts as {} m tall, up is the "
                  "normal of the ring of cameras, the floor lies under the feet.",
                  kHeight),
      "The calibration's skew (1 to 2 px over 900) has no place in our camera model and is "
      "dropped: "
      "up to 0.6 px at the picture's edges.",
      "No plate: the set shows no empty scene, so hulls and views rest on the given masks. The "
      "difference key falls back to the floor's colour, and knows nothing before the black wall; "
      "keying by colour comes with the colour classifier. No colour match between cameras.",
  };
  return report;
}

}  // namespace touchline::score
