#include <embree3/rtcore.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <vector>

#include "hub/render/hull_surfaces_internal.h"

namespace touchline::render {
namespace {

constexpr float kStep = 2e-4f;  // metres past a hit before the next is looked for
constexpr int kMostHits = 48;

struct Hit {
  int group = -1;
  float distance = 0;
  bool entering = false;
};

}  // namespace

struct HullSurfaces::Impl {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  Impl() = default;
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() {
    if (scene != nullptr) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
  }

  // The next surface beyond `near`; false when there is none.
  bool next(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, float near, float far,
            Hit& hit) const {
    RTCRayHit ray{};
    ray.ray.org_x = static_cast<float>(origin.x());
    ray.ray.org_y = static_cast<float>(origin.y());
    ray.ray.org_z = static_cast<float>(origin.z());
    ray.ray.dir_x = static_cast<float>(direction.x());
    ray.ray.dir_y = static_cast<float>(direction.y());
    ray.ray.dir_z = static_cast<float>(direction.z());
    ray.ray.tnear = near;
    ray.ray.tfar = far;
    ray.ray.mask = std::numeric_limits<unsigned>::max();
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene, &context, &ray);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    hit.group = static_cast<int>(ray.hit.geomID);
    hit.distance = ray.ray.tfar;
    hit.entering =
        ray.hit.Ng_x * ray.ray.dir_x + ray.hit.Ng_y * ray.ray.dir_y + ray.hit.Ng_z * ray.ray.dir_z <
        0;
    return true;
  }
};

HullSurfaces::HullSurfaces(const scene::Hull& hull) : impl_(std::make_unique<Impl>()) {
  impl_->device = rtcNewDevice("threads=0");
  impl_->scene = rtcNewScene(impl_->device);
  rtcSetSceneFlags(impl_->scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(impl_->scene, RTC_BUILD_QUALITY_LOW);
  for (std::size_t i = 0; i < hull.groups.size(); ++i) {
    const scene::HullGroup& group = hull.groups[i];
    const geometry::Mesh& mesh = group.surface;
    if (group.phantom || mesh.vertices.empty() || mesh.triangles.empty()) continue;
    RTCGeometry shape = rtcNewGeometry(impl_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(
        rtcSetNewGeometryBuffer(shape, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), mesh.vertices.size()));
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      for (int k = 0; k < 3; ++k)
        vertices[3 * v + static_cast<std::size_t>(k)] = mesh.vertices[v][k];
    }
    void* triangles = rtcSetNewGeometryBuffer(shape, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                              3 * sizeof(std::uint32_t), mesh.triangles.size());
    std::memcpy(triangles, mesh.triangles.data(),
                mesh.triangles.size() * 3 * sizeof(std::uint32_t));
    rtcSetGeometryBuildQuality(shape, RTC_BUILD_QUALITY_LOW);
    rtcCommitGeometry(shape);
    rtcAttachGeometryByID(impl_->scene, shape, static_cast<unsigned>(i));
    rtcReleaseGeometry(shape);
  }
  rtcCommitScene(impl_->scene);
}

HullSurfaces::HullSurfaces(HullSurfaces&&) noexcept = default;
HullSurfaces& HullSurfaces::operator=(HullSurfaces&&) noexcept = default;
HullSurfaces::~HullSurfaces() = default;

Intervals HullSurfaces::intervals(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                  double far) const {
  Intervals out;
  float near = 0;
  Hit hit;
  for (int n = 0; n < kMostHits; ++n) {
    if (!impl_->next(origin, direction, near, static_cast<float>(far), hit)) break;
    near = hit.distance + kStep;
    Interval* open = nullptr;
    for (int i = 0; i < out.count; ++i) {
      Interval& item = out.items[static_cast<std::size_t>(i)];
      if (item.group == hit.group && item.leave < 0) open = &item;
    }
    if (hit.entering) {
      if (open != nullptr) continue;  // an edge met twice
      if (out.count == static_cast<int>(out.items.size())) break;
      out.items[static_cast<std::size_t>(out.count++)] = {hit.group, hit.distance, -1};
    } else if (open != nullptr) {
      open->leave = hit.distance;
    } else {
      bool started = false;
      for (int i = 0; i < out.count; ++i) {
        started = started || out.items[static_cast<std::size_t>(i)].group == hit.group;
      }
      // The origin lies inside the group; any other exit without entry is an edge met twice.
      if (started || out.count == static_cast<int>(out.items.size())) continue;
      out.items[static_cast<std::size_t>(out.count++)] = {hit.group, 0, hit.distance};
    }
  }
  for (int i = 0; i < out.count; ++i) {
    Interval& item = out.items[static_cast<std::size_t>(i)];
    if (item.leave < 0) item.leave = std::min(far, item.enter + 1.0);
  }
  std::sort(out.items.begin(), out.items.begin() + out.count,
            [](const Interval& a, const Interval& b) {
              return a.enter != b.enter ? a.enter < b.enter : a.group < b.group;
            });
  return out;
}

HullSurfaces::Blocking HullSurfaces::blocking(const Eigen::Vector3d& point,
                                              const Eigen::Vector3d& camera, int group) const {
  Blocking out;
  const Eigen::Vector3d way = camera - point;
  const double length = way.norm();
  if (length < 1e-6) return out;
  const Eigen::Vector3d direction = way / length;
  float near = 0;
  float entered = -1;
  int inside = -1;  // the group that was entered last, not yet left
  bool left_own = false;
  Hit hit;
  for (int n = 0; n < kMostHits; ++n) {
    if (!impl_->next(point, direction, near, static_cast<float>(length), hit)) break;
    near = hit.distance + kStep;
    if (hit.entering) {
      if (inside < 0) {
        inside = hit.group;
        entered = hit.distance;
      }
    } else if (hit.group == group && !left_own && inside != group) {
      out.own = hit.distance;
      left_own = true;
    } else if (inside == hit.group) {
      out.other += hit.distance - entered;
      inside = -1;
    }
    if (out.other > 1) break;
  }
  if (inside >= 0) out.other += 1;
  return out;
}

int HullSurfaces::first(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
  Hit hit;
  return impl_->next(origin, direction, 0, std::numeric_limits<float>::infinity(), hit) ? hit.group
                                                                                        : -1;
}

}  // namespace touchline::render
