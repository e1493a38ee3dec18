#include "rali/sim/ray_caster.hpp"

#include <algorithm>
#include <array>
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
    // One thread: the scene is small and its tree must not depend on scheduling. No instructions
    // beyond AVX: with fused multiply-add the last bits of ranges differ between processors.
    device = rtcNewDevice("threads=1,set_affinity=0,max_isa=avx");
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
    // "threads=1" limits TBB to one thread in the whole process as long as the device lives. A
    // second device without a limit removes this restriction.
    unlimited = rtcNewDevice("set_affinity=0");
    RALI_ASSERT(unlimited != nullptr);
  }

  ~Impl() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
    rtcReleaseDevice(unlimited);
  }

  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  RTCDevice device = nullptr;
  RTCDevice unlimited = nullptr;
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
  const Ray ray{origin, direction};
  Hit hit;
  cast_all({&ray, 1}, max_range_m, {&hit, 1});
  return hit;
}

namespace {

constexpr std::size_t kPacket = 8;

void fill(const Ray& ray, std::size_t k, float reach_m, RTCRayHit8& packet) {
  packet.ray.org_x[k] = static_cast<float>(ray.origin.x());
  packet.ray.org_y[k] = static_cast<float>(ray.origin.y());
  packet.ray.org_z[k] = static_cast<float>(ray.origin.z());
  packet.ray.dir_x[k] = static_cast<float>(ray.direction.x());
  packet.ray.dir_y[k] = static_cast<float>(ray.direction.y());
  packet.ray.dir_z[k] = static_cast<float>(ray.direction.z());
  packet.ray.tnear[k] = 0.0F;
  packet.ray.tfar[k] = reach_m;
  packet.ray.time[k] = 0.0F;
  packet.ray.mask[k] = 0xFFFFFFFFU;
  packet.ray.id[k] = 0;
  packet.ray.flags[k] = 0;
  packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
  packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
}

Hit hit_of(const RTCRayHit8& packet, std::size_t k, const std::vector<float>& reflectivity) {
  if (packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) return {};
  const float nx = packet.hit.Ng_x[k];
  const float ny = packet.hit.Ng_y[k];
  const float nz = packet.hit.Ng_z[k];
  const float dot = nx * packet.ray.dir_x[k] + ny * packet.ray.dir_y[k] + nz * packet.ray.dir_z[k];
  const float norm = std::sqrt(nx * nx + ny * ny + nz * nz);
  return {packet.ray.tfar[k], norm > 0.0F ? std::abs(dot) / norm : 0.0F,
          reflectivity[packet.hit.primID[k]]};
}

}  // namespace

void RayCaster::cast_all(std::span<const Ray> rays, double max_range_m, std::span<Hit> hits) const {
  RALI_ASSERT(rays.size() == hits.size());
  const float reach_m = static_cast<float>(max_range_m);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  alignas(32) RTCRayHit8 packet{};
  for (std::size_t first = 0; first < rays.size(); first += kPacket) {
    const std::size_t n = std::min(kPacket, rays.size() - first);
    alignas(32) std::array<int, kPacket> valid{};
    for (std::size_t k = 0; k < n; ++k) {
      valid[k] = -1;
      fill(rays[first + k], k, reach_m, packet);
    }
    rtcIntersect8(valid.data(), impl_->scene, &context, &packet);
    for (std::size_t k = 0; k < n; ++k) {
      hits[first + k] = hit_of(packet, k, impl_->reflectivity);
    }
  }
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

namespace {

/// True if all corners are farther than reach_m from p along one axis.
bool out_of_reach(const geometry::Vec3f& p, const geometry::Vec3f& a, const geometry::Vec3f& b,
                  const geometry::Vec3f& c, float reach_m) {
  const geometry::Vec3f low = a.cwiseMin(b).cwiseMin(c);
  const geometry::Vec3f high = a.cwiseMax(b).cwiseMax(c);
  return ((low - p).array() > reach_m).any() || ((p - high).array() > reach_m).any();
}

}  // namespace

double RayCaster::distance_to_surface(const Vec3& point, double limit_m) const {
  double best = limit_m;
  const geometry::Vec3f p = point.cast<float>();
  constexpr float kRounding_m = 1e-3F;
  for (const std::array<std::uint32_t, 3>& t : impl_->triangles) {
    const float reach_m = static_cast<float>(best) + kRounding_m;
    if (out_of_reach(p, impl_->vertices[t[0]], impl_->vertices[t[1]], impl_->vertices[t[2]],
                     reach_m)) {
      continue;
    }
    best = std::min(best, distance_to_triangle(point, impl_->vertices[t[0]].cast<double>(),
                                               impl_->vertices[t[1]].cast<double>(),
                                               impl_->vertices[t[2]].cast<double>()));
  }
  return best;
}

}  // namespace rali::sim
