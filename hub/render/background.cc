#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "hub/render/background_internal.h"
#include "hub/render/fill_internal.h"

namespace touchline::render {
namespace {

constexpr int kBlock = 8;           // pixels between exact evaluations
constexpr double kCoarsePx = 16;    // pixels of the view that the coarse band averages
constexpr double kSoftSlope = 1.5;  // of log weight over penalty
constexpr double kSharpSlope = 10;
constexpr double kBehindNet = 2;  // penalty of a camera that sees a point through a goal's net

float smooth_step(double t) {
  const double s = std::clamp(t, 0.0, 1.0);
  return static_cast<float>(s * s * (3 - 2 * s));
}

}  // namespace

struct BackgroundRenderer::View {
  const geometry::CameraEstimate& camera;
  Eigen::Vector3d origin;
  Eigen::Matrix3d world_from_cam;
  int columns = 0;
  int rows = 0;
  std::vector<Corner> corners;
  std::vector<Term> terms;  // of all cameras, corner by corner

  Eigen::Vector3d ray(double x, double y) const {
    return (world_from_cam * camera.model.unproject({x, y})).normalized();
  }
  std::size_t corner_at(int bx, int by) const {
    return static_cast<std::size_t>(by) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(bx);
  }
};

BackgroundRenderer::BackgroundRenderer(const pitch::PitchModel& pitch, Stadium stadium,
                                       std::vector<PlateCamera> cameras,
                                       const RenderOptions& options)
    : pitch_(pitch),
      stadium_(std::move(stadium)),
      cameras_(std::move(cameras)),
      options_(options),
      goals_(pitch) {
  turf_colour_ = mean_turf();
}

Eigen::Vector3f BackgroundRenderer::mean_turf() const {
  std::array<std::vector<float>, 3> values;
  for (double y = -pitch_.width_m / 2; y <= pitch_.width_m / 2; y += 2) {
    for (double x = -pitch_.length_m / 2; x <= pitch_.length_m / 2; x += 2) {
      for (const PlateCamera& camera : cameras_) {
        const Eigen::Vector3d d = pitch_.on_turf({x, y}) - camera.texture.centre_in_world();
        const Eigen::Vector2f p = camera.texture.position(d);
        if (camera.texture.border_distance(p.x(), p.y()) <= 0) continue;
        const Sample s = camera.texture.sample(p.x(), p.y(), 4);
        if (s.weight <= 0) continue;
        for (int k = 0; k < 3; ++k) values[static_cast<std::size_t>(k)].push_back(s.colour[k]);
      }
    }
  }
  if (values[0].size() < 10) return turf_colour_;
  Eigen::Vector3f median;
  for (int k = 0; k < 3; ++k) {
    std::vector<float>& v = values[static_cast<std::size_t>(k)];
    const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
    std::nth_element(v.begin(), middle, v.end());
    median[k] = *middle;
  }
  return median;
}

GroundPoint BackgroundRenderer::ground_at(const Eigen::Vector3d& origin,
                                          const Eigen::Vector3d& direction) const {
  GroundPoint best;
  best.distance = std::numeric_limits<double>::infinity();
  if (const auto turf = pitch::intersect_turf(pitch_, origin, direction)) {
    best.surface = kTurfSurface;
    best.point = *turf;
    best.normal = Eigen::Vector3d::UnitZ();
    best.distance = (*turf - origin).norm();
  }
  if (const auto hit = intersect(stadium_, origin, direction)) {
    if (hit->distance < best.distance) {
      best.surface = static_cast<int>(hit->side);
      best.point = origin + hit->distance * direction;
      best.normal = hit->normal_in_world;
      best.distance = hit->distance;
    }
  }
  return best;
}

void BackgroundRenderer::evaluate(const View& view, double x, double y, Corner& corner,
                                  Term* terms) const {
  const Eigen::Vector3d ray = view.ray(x, y);
  const GroundPoint ground = ground_at(view.origin, ray);
  corner.surface = ground.surface;
  corner.distance = ground.distance;
  const double pixel = 1 / view.camera.model.fx;  // radians
  const double feather = options_.border_feather_deg * std::numbers::pi / 180;
  const double angle_scale = options_.background_angle_deg * std::numbers::pi / 180;
  std::array<double, 64> penalty;
  std::array<float, 64> cover;
  const std::size_t count = std::min<std::size_t>(cameras_.size(), penalty.size());
  double least = std::numeric_limits<double>::infinity();
  corner.seen = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const PlateTexture& texture = cameras_[i].texture;
    Term& term = terms[i];
    term = Term{};
    cover[i] = 0;
    Eigen::Vector3d d = ray;
    double angle = 0;
    bool away = false;
    if (ground.surface != kSkySurface) {
      d = ground.point - texture.centre_in_world();
      const double distance = std::max(d.norm(), 1e-6);
      const double facing = -d.dot(ground.normal) / distance;
      away = facing < 0.005;
      const double cosine = std::max(0.005, facing);
      const double view_cosine = std::max(0.005, -ray.dot(ground.normal));
      const double own = texture.radians_per_px() * distance;
      const double wanted = pixel * ground.distance;
      term.texels = static_cast<float>(wanted / own * std::sqrt(cosine / view_cosine));
      angle = std::acos(std::clamp(d.dot(ray) / distance, -1.0, 1.0));
    }
    if (ground.surface == kSkySurface)
      term.texels = static_cast<float>(pixel / texture.radians_per_px());
    const Eigen::Vector2f p = texture.position(d);
    term.u = p.x();
    term.v = p.y();
    if (away) continue;
    const float border = texture.border_distance(p.x(), p.y());
    if (border <= 0) continue;
    cover[i] = feather > 0 ? smooth_step(border / feather) : 1.f;
    penalty[i] = angle / angle_scale +
                 options_.resolution_weight *
                     std::max(0.0, -std::log2(static_cast<double>(std::max(term.texels, 1e-6f))));
    if (ground.surface != kSkySurface && goals_.hides(texture.centre_in_world(), ground.point)) {
      penalty[i] += kBehindNet;
    }
    least = std::min(least, penalty[i]);
    corner.seen = std::max(corner.seen, cover[i]);
  }
  float soft = 0;
  float sharp = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (cover[i] <= 0) continue;
    const double worse = penalty[i] - least;
    terms[i].soft = cover[i] * static_cast<float>(std::exp(-kSoftSlope * worse));
    terms[i].sharp = cover[i] * static_cast<float>(std::exp(-kSharpSlope * worse));
    soft += terms[i].soft;
    sharp += terms[i].sharp;
  }
  corner.correction.setZero();
  if (soft <= 0 || sharp <= 0) return;
  for (std::size_t i = 0; i < count; ++i) {
    Term& term = terms[i];
    if (cover[i] <= 0) continue;
    term.soft /= soft;
    term.sharp /= sharp;
    const float excess = term.soft - term.sharp;
    if (std::abs(excess) < 1e-3f) continue;
    const float width = static_cast<float>(kCoarsePx) * term.texels;
    const Sample s = cameras_[i].texture.sample(term.u, term.v, {width, 0}, {0, width});
    corner.correction += excess * s.colour;
  }
}

void BackgroundRenderer::render_block(const View& view, int bx, int by, Background& out,
                                      double* share) const {
  const int x0 = bx * kBlock;
  const int y0 = by * kBlock;
  const int x1 = std::min(x0 + kBlock, out.colour.width());
  const int y1 = std::min(y0 + kBlock, out.colour.height());
  const std::size_t n = cameras_.size();
  const std::array<std::size_t, 4> at = {view.corner_at(bx, by), view.corner_at(bx + 1, by),
                                         view.corner_at(bx, by + 1),
                                         view.corner_at(bx + 1, by + 1)};
  const Corner& first = view.corners[at[0]];
  bool even = true;
  double near = first.distance;
  double far = first.distance;
  for (const std::size_t k : at) {
    even = even && view.corners[k].surface == first.surface;
    near = std::min(near, view.corners[k].distance);
    far = std::max(far, view.corners[k].distance);
  }
  if (first.surface != kSkySurface && far > 1.15 * near) even = false;

  if (!even) {
    std::vector<Term> terms(n);
    Corner corner;
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) {
        evaluate(view, x, y, corner, terms.data());
        Eigen::Vector3f colour = corner.correction;
        for (std::size_t i = 0; i < n; ++i) {
          if (terms[i].sharp < 0.004f) continue;
          const float w = terms[i].texels;
          colour += terms[i].sharp *
                    cameras_[i].texture.sample(terms[i].u, terms[i].v, {w, 0}, {0, w}).colour;
          share[i] += static_cast<double>(terms[i].sharp * corner.seen);
        }
        out.colour(x, y) = colour;
        out.seen(x, y) = corner.seen;
        out.surface(x, y) = static_cast<std::int8_t>(corner.surface);
        out.distance(x, y) = static_cast<float>(corner.distance);
      }
    }
    return;
  }

  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      const float fx = static_cast<float>(x - x0) / kBlock;
      const float fy = static_cast<float>(y - y0) / kBlock;
      const std::array<float, 4> w = {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
      Eigen::Vector3f colour = Eigen::Vector3f::Zero();
      float seen = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        colour += w[k] * view.corners[at[k]].correction;
        seen += w[k] * view.corners[at[k]].seen;
      }
      out.colour(x, y) = colour;
      out.seen(x, y) = seen;
      out.surface(x, y) = static_cast<std::int8_t>(first.surface);
      out.distance(x, y) = static_cast<float>(0.5 * (near + far));
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    std::array<Term, 4> t;
    float most = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      t[k] = view.terms[at[k] * n + i];
      most = std::max(most, t[k].sharp);
    }
    if (most < 0.004f) continue;
    const PlateTexture& texture = cameras_[i].texture;
    for (std::size_t k = 0; k < 4; ++k) t[k].u = texture.unwrapped(t[k].u, t[0].u);
    const Eigen::Vector2f step_x =
        Eigen::Vector2f(t[1].u - t[0].u + t[3].u - t[2].u, t[1].v - t[0].v + t[3].v - t[2].v) /
        (2 * kBlock);
    const Eigen::Vector2f step_y =
        Eigen::Vector2f(t[2].u - t[0].u + t[3].u - t[1].u, t[2].v - t[0].v + t[3].v - t[1].v) /
        (2 * kBlock);
    double sum = 0;
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) {
        const float fx = static_cast<float>(x - x0) / kBlock;
        const float fy = static_cast<float>(y - y0) / kBlock;
        const std::array<float, 4> w = {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
        const float sharp =
            w[0] * t[0].sharp + w[1] * t[1].sharp + w[2] * t[2].sharp + w[3] * t[3].sharp;
        if (sharp < 0.002f) continue;
        const float u = w[0] * t[0].u + w[1] * t[1].u + w[2] * t[2].u + w[3] * t[3].u;
        const float v = w[0] * t[0].v + w[1] * t[1].v + w[2] * t[2].v + w[3] * t[3].v;
        out.colour(x, y) += sharp * texture.sample(u, v, step_x, step_y).colour;
        sum += static_cast<double>(sharp * out.seen(x, y));
      }
    }
    share[i] += sum;
  }
}

Background BackgroundRenderer::render(const geometry::CameraEstimate& camera) const {
  const int width = camera.model.width;
  const int height = camera.model.height;
  View view{camera,
            geometry::position_in_world(camera),
            camera.cam_from_world.rotation.conjugate().toRotationMatrix(),
            (width + kBlock - 1) / kBlock + 1,
            (height + kBlock - 1) / kBlock + 1,
            {},
            {}};
  const std::size_t n = cameras_.size();
  view.corners.resize(static_cast<std::size_t>(view.columns) * static_cast<std::size_t>(view.rows));
  view.terms.resize(view.corners.size() * n);
  tbb::parallel_for(0, view.rows, [&](int by) {
    for (int bx = 0; bx < view.columns; ++bx) {
      const std::size_t k = view.corner_at(bx, by);
      evaluate(view, bx * kBlock, by * kBlock, view.corners[k], view.terms.data() + k * n);
    }
  });
  Background out;
  out.colour = image::Image<Eigen::Vector3f>(width, height, Eigen::Vector3f::Zero());
  out.seen = image::Image<float>(width, height);
  out.surface = image::Image<std::int8_t>(width, height);
  out.distance = image::Image<float>(width, height);
  std::vector<double> shares(static_cast<std::size_t>(view.rows) * n, 0);
  tbb::parallel_for(0, view.rows - 1, [&](int by) {
    for (int bx = 0; bx + 1 < view.columns; ++bx) {
      render_block(view, bx, by, out, shares.data() + static_cast<std::size_t>(by) * n);
    }
  });
  out.share.assign(n, 0);
  for (std::size_t k = 0; k < shares.size(); ++k) out.share[k % n] += shares[k];
  for (double& s : out.share) s /= static_cast<double>(out.colour.size());
  fill_unseen(view, out);
  return out;
}

void BackgroundRenderer::fill_unseen(const View& view, Background& out) const {
  // Turf: the mean colour of known turf. Else: what is seen nearby, over a neutral gradient.
  image::Image<Eigen::Vector3f> spread(out.colour.width(), out.colour.height(),
                                       Eigen::Vector3f::Zero());
  image::Image<float> weight(out.colour.width(), out.colour.height(), 0.f);
  bool wanted = false;
  for (int y = 0; y < out.colour.height(); ++y) {
    for (int x = 0; x < out.colour.width(); ++x) {
      const float seen = out.seen(x, y);
      if (out.surface(x, y) == kTurfSurface) {
        if (seen < 0.999f) out.colour(x, y) = seen * out.colour(x, y) + (1 - seen) * turf_colour_;
        continue;
      }
      wanted = wanted || seen < 0.999f;
      spread(x, y) = out.colour(x, y);
      weight(x, y) = seen;
    }
  }
  if (!wanted) return;
  fill_smoothly(spread, weight, [&](double x, double y) {
    const double rise = view.ray(x, y).z();
    const auto grey = static_cast<float>(120 + 90 * std::clamp(2 * rise, 0.0, 1.0));
    return Eigen::Vector3f(grey, grey, grey + 4);
  });
  for (int y = 0; y < out.colour.height(); ++y) {
    for (int x = 0; x < out.colour.width(); ++x) {
      if (out.surface(x, y) != kTurfSurface) out.colour(x, y) = spread(x, y);
    }
  }
}

}  // namespace touchline::render
