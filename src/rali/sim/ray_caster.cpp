#include "rali/sim/ray_caster.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <Eigen/Geometry>
#include <embree3/rtcore.h>

#include "rali/base/assert.hpp"

namespace rali::sim {

using geometry::Vec3;

struct RayCaster::Impl {
  explicit Impl(const TriangleMesh& mesh)
      : triangles(mesh.triangles), reflectivity(mesh.reflectivity) {
    // One thread: the scene is small and its tree must not depend on scheduling.
    device = rtcNewDevice("threads=1,set_affinity=0");
    RALI_ASSERT(device != nullptr);
    scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertex = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               mesh.vertices.size()));
    auto* index = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(unsigned), triangles.size()));
    RALI_ASSERT(vertex != nullptr && index != nullptr);
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      for (Eigen::Index k = 0; k < 3; ++k)
        vertex[3 * i + static_cast<std::size_t>(k)] = mesh.vertices[i][k];
    }
    std::memcpy(index, triangles.data(), triangles.size() * 3 * sizeof(unsigned));
    vertices = mesh.vertices;
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    RALI_ASSERT(rtcGetDeviceError(device) == RTC_ERROR_NONE);
  }

  ~Impl() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }

  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::vector<geometry::Vec3f> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<float> reflectivity;
};

RayCaster::RayCaster(const TriangleMesh& mesh) : impl_(std::make_unique<Impl>(mesh)) {}

RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;
RayCaster& RayCaster::operator=(RayCaster&&) noexcept = default;

Hit RayCaster::cast(const Vec3& origin, const Vec3& direction, double max_range_m) const {
  RTCRayHit ray{};
  ray.ray.org_x = static_cast<float>(origin.x());
  ray.ray.org_y = static_cast<float>(origin.y());
  ray.ray.org_z = static_cast<float>(origin.z());
  ray.ray.dir_x = static_cast<float>(direction.x());
  ray.ray.dir_y = static_cast<float>(direction.y());
  ray.ray.dir_z = static_cast<float>(direction.z());
  ray.ray.tnear = 0.0F;
  ray.ray.tfar = static_cast<float>(max_range_m);
  ray.ray.mask = 0xFFFFFFFFU;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(impl_->scene, &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  const float nx = ray.hit.Ng_x;
  const float ny = ray.hit.Ng_y;
  const float nz = ray.hit.Ng_z;
  const float dot = nx * ray.ray.dir_x + ny * ray.ray.dir_y + nz * ray.ray.dir_z;
  const float norm = std::sqrt(nx * nx + ny * ny + nz * nz);
  return {ray.ray.tfar, norm > 0.0F ? std::abs(dot) / norm : 0.0F,
          impl_->reflectivity[ray.hit.primID]};
}

namespace {

/// Distance of p to the triangle abc: foot of the perpendicular if it lies inside, else the
/// nearest edge.
double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto to_edge = [&](const Vec3& from, const Vec3& to) {
    const Vec3 e = to - from;
    const double u = std::clamp((p - from).dot(e) / std::max(e.squaredNorm(), 1e-18), 0.0, 1.0);
    return (p - from - u * e).norm();
  };
  const Vec3 n = (b - a).cross(c - a);
  const double n2 = n.squaredNorm();
  if (n2 > 1e-18) {
    const bool inside = (b - a).cross(p - a).dot(n) >= 0.0 && (c - b).cross(p - b).dot(n) >= 0.0 &&
                        (a - c).cross(p - c).dot(n) >= 0.0;
    if (inside) return std::abs((p - a).dot(n)) / std::sqrt(n2);
  }
  return std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)});
}

}  // namespace

double RayCaster::distance_to_surface(const Vec3& point, double limit_m) const {
  double best = limit_m;
  for (const std::array<std::uint32_t, 3>& t : impl_->triangles) {
    best = std::min(best, distance_to_triangle(point, impl_->vertices[t[0]].cast<double>(),
                                               impl_->vertices[t[1]].cast<double>(),
                                               impl_->vertices[t[2]].cast<double>()));
  }
  return best;
}

}  // namespace rali::sim
