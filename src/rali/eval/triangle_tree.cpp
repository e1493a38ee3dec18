#include "rali/eval/triangle_tree.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include <Eigen/Geometry>
#include <embree3/rtcore.h>

#include "rali/base/assert.hpp"

namespace rali::eval {

using geometry::Vec3;

namespace {

Vec3 closest_on_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double length2 = ab.squaredNorm();
  if (!(length2 > 0.0)) return a;
  return a + std::clamp(ab.dot(p - a) / length2, 0.0, 1.0) * ab;
}

Vec3 closest_on_edges(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  Vec3 best = closest_on_segment(p, a, b);
  for (const Vec3& q : {closest_on_segment(p, b, c), closest_on_segment(p, c, a)}) {
    if ((q - p).squaredNorm() < (best - p).squaredNorm()) best = q;
  }
  return best;
}

}  // namespace

// Six dot products determine the nearest corner, edge or face (Ericson, Real-Time Collision
// Detection, 2005, 5.1.5).
Vec3 closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  // The normal of a sliver is dominated by rounding, its edges are not.
  const double sine2_min = 1e-16 * ab.squaredNorm() * ac.squaredNorm();
  if (!(ab.cross(ac).squaredNorm() > sine2_min)) return closest_on_edges(p, a, b, c);
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return a;
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return b;
  const double w_c = d1 * d4 - d3 * d2;
  if (w_c <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return a + d1 / (d1 - d3) * ab;
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return c;
  const double w_b = d5 * d2 - d1 * d6;
  if (w_b <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return a + d2 / (d2 - d6) * ac;
  const double w_a = d3 * d6 - d5 * d4;
  const double from_b = d4 - d3, from_c = d5 - d6;
  if (w_a <= 0.0 && from_b >= 0.0 && from_c >= 0.0) {
    return b + from_b / (from_b + from_c) * (c - b);
  }
  return a + (w_b * ab + w_c * ac) / (w_a + w_b + w_c);
}

struct TriangleTree::Impl {
  struct Query;

  explicit Impl(const TriangleMesh& of) : mesh(of) {
    Vec3 low = mesh.vertices[mesh.triangles[0][0]], high = low;
    for (const Vec3& v : mesh.vertices) {
      low = low.cwiseMin(v);
      high = high.cwiseMax(v);
    }
    // Coordinates relative to the mesh centre: single precision is not lost to a distant origin.
    middle = 0.5 * (low + high);
    size_m = (high - low).maxCoeff();
    device = rtcNewDevice("set_affinity=0");
    RALI_ASSERT(device != nullptr);
    scene = rtcNewScene(device);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertex = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               mesh.vertices.size()));
    auto* index = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(unsigned), mesh.triangles.size()));
    RALI_ASSERT(vertex != nullptr && index != nullptr);
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      Eigen::Map<geometry::Vec3f>(vertex + 3 * i) = (mesh.vertices[i] - middle).cast<float>();
    }
    std::memcpy(index, mesh.triangles.data(), mesh.triangles.size() * 3 * sizeof(unsigned));
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

  [[nodiscard]] std::array<Vec3, 3> corners(std::uint32_t t) const {
    const auto& [a, b, c] = mesh.triangles[t];
    return {mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]};
  }

  TriangleMesh mesh;
  Vec3 middle = Vec3::Zero();
  double size_m = 0.0;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
};

/// Best result of one query so far.
struct TriangleTree::Impl::Query {
  const Impl& tree;
  const Vec3& p;
  double margin_m;  ///< rounding of Embree's coordinates about p
  double best2 = std::numeric_limits<double>::infinity();
  Nearest best = {};

  /// Called for each triangle in range. @return true if the search radius has decreased
  static bool look_at(RTCPointQueryFunctionArguments* args) {
    auto& query = *static_cast<Query*>(args->userPtr);
    const auto [a, b, c] = query.tree.corners(args->primID);
    const Vec3 q = closest_on_triangle(query.p, a, b, c);
    const double d2 = (q - query.p).squaredNorm();
    if (d2 > query.best2 || (d2 == query.best2 && args->primID > query.best.triangle)) return false;
    query.best2 = d2;
    query.best = {std::sqrt(d2), q, args->primID};
    const auto reach_m = static_cast<float>(query.best.distance_m * kRoundUp + query.margin_m);
    if (reach_m >= args->query->radius) return false;
    args->query->radius = reach_m;
    return true;
  }

  static constexpr double kRoundUp = 1.0 + 1e-6;
};

TriangleTree::TriangleTree(const TriangleMesh& mesh) : impl_(std::make_unique<Impl>(mesh)) {}

TriangleTree::~TriangleTree() = default;

TriangleTree::Nearest TriangleTree::nearest(const Vec3& p) const {
  const Vec3 local = p - impl_->middle;
  // Embree rounds p, corners and boxes by 2^-24 each; the margin is sixteen times that.
  Impl::Query found{*impl_, p, 1e-6 * (impl_->size_m + local.cwiseAbs().maxCoeff())};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  RTCPointQuery query{};
  query.x = static_cast<float>(local.x());
  query.y = static_cast<float>(local.y());
  query.z = static_cast<float>(local.z());
  query.radius = std::numeric_limits<float>::infinity();
  rtcPointQuery(impl_->scene, &query, &context, &Impl::Query::look_at, &found);
  return found.best;
}

Vec3 TriangleTree::normal(std::uint32_t triangle) const {
  const auto [a, b, c] = impl_->corners(triangle);
  const Vec3 n = (b - a).cross(c - a);
  const double length = n.norm();
  return length > 0.0 ? Vec3(n / length) : Vec3::Zero();
}

}  // namespace rali::eval
