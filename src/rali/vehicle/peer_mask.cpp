#include "rali/vehicle/peer_mask.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "rali/base/rng.hpp"
#include "rali/geometry/pca3.hpp"
#include "rali/vehicle/peer_places.hpp"

namespace rali::vehicle {

using geometry::Mat3;
using geometry::Vec3;
using geometry::Vec3f;
using sensor::LidarScan;

namespace {

/// An upright cylinder in the frame of the LiDAR.
struct Cylinder {
  Vec3f p;
  Vec3f up;
  float radius_m;
};

/// A plane in the frame of the LiDAR: n.x = d.
struct Surface {
  Vec3f n = Vec3f::Zero();
  float d_m = 0.0F;

  [[nodiscard]] bool has(const Vec3f& x, float thickness_m) const {
    return std::abs(n.dot(x) - d_m) < thickness_m;
  }
};

/// Floor, two walls and one object beside them.
constexpr int kSurfacesMax = 4;
/// Covers the roughness of floors and walls and the noise of ranges.
constexpr float kThickness_m = 0.05F;
/// Extent of the surroundings in radii, and the number of their points that are used.
constexpr float kReach = 2.0F;
constexpr std::size_t kAroundMax = 240;
/// Fewer points define no surface.
constexpr std::size_t kPointsMin = 12;
/// Of a hundred random triangles of points on three surfaces, several lie within each.
constexpr int kTriangles = 100;
/// Smaller triangles, in radii squared, may lie on a side of the vehicle.
constexpr float kAreaMin = 0.3F;

/// Whether a point is within the level radius and the heights above and below.
bool within(const Cylinder& c, const Vec3f& point, float radius_m, float above_m, float below_m) {
  const Vec3f d = point - c.p;
  const float height = d.dot(c.up);
  if (height > above_m || height < -below_m) return false;
  return (d - height * c.up).squaredNorm() < radius_m * radius_m;
}

bool holds(const Cylinder& c, const Vec3f& point, const PeerMaskSettings& s) {
  return within(c, point, c.radius_m, static_cast<float>(s.above_m), static_cast<float>(s.below_m));
}

Vec3f point_of(const LidarScan& scan, std::size_t i) {
  return {scan.x_m[i], scan.y_m[i], scan.z_m[i]};
}

/// Points beside the cylinder, evenly thinned.
std::vector<Vec3f> around(const LidarScan& scan, const Cylinder& c, const PeerMaskSettings& s) {
  const float radius_m = c.radius_m;
  const float reach_m = kReach * radius_m;
  const float above_m = static_cast<float>(s.above_m) + radius_m;
  const float below_m = static_cast<float>(s.below_m) + radius_m;
  std::vector<Vec3f> all;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const Vec3f x = point_of(scan, i);
    if (!within(c, x, reach_m, above_m, below_m)) continue;
    const Vec3f d = x - c.p;
    if ((d - d.dot(c.up) * c.up).squaredNorm() > radius_m * radius_m) all.push_back(x);
  }
  if (all.size() <= kAroundMax) return all;
  std::vector<Vec3f> out;
  for (std::size_t k = 0; k < kAroundMax; ++k) out.push_back(all[k * all.size() / kAroundMax]);
  return out;
}

std::size_t count(const std::vector<Vec3f>& points, const Surface& s) {
  return static_cast<std::size_t>(std::count_if(
      points.begin(), points.end(), [&](const Vec3f& x) { return s.has(x, kThickness_m); }));
}

/// The best plane through all points near it.
Surface refined(const std::vector<Vec3f>& points, const Surface& rough) {
  Vec3 sum = Vec3::Zero();
  Mat3 squares = Mat3::Zero();
  double n = 0.0;
  for (const Vec3f& x : points) {
    if (!rough.has(x, kThickness_m)) continue;
    const Vec3 p = x.cast<double>();
    sum += p;
    squares += p * p.transpose();
    n += 1.0;
  }
  const Vec3 mean = sum / n;
  const geometry::Pca3 pca = geometry::pca3(squares / n - mean * mean.transpose());
  Surface out;
  out.n = pca.vectors.col(2).cast<float>();
  out.d_m = static_cast<float>(pca.vectors.col(2).dot(mean));
  return out;
}

/// The plane with most points, by RANSAC (Fischler and Bolles 1981); nothing if there is none.
std::optional<Surface> surface_of_most(const std::vector<Vec3f>& points, float area_min_m2,
                                       Rng& rng) {
  Surface best;
  std::size_t maximum = 0;
  for (int k = 0; k < kTriangles; ++k) {
    const Vec3f a = points[rng.below(points.size())];
    const Vec3f b = points[rng.below(points.size())];
    const Vec3f c = points[rng.below(points.size())];
    const Vec3f normal = (b - a).cross(c - a);
    if (0.5F * normal.norm() < area_min_m2) continue;
    Surface s;
    s.n = normal.normalized();
    s.d_m = s.n.dot(a);
    const std::size_t n = count(points, s);
    if (n > maximum) best = s;
    maximum = std::max(maximum, n);
  }
  if (maximum < kPointsMin) return std::nullopt;
  return refined(points, best);
}

/// Surfaces below and beside the vehicle, by the points around it, where no vehicle reaches.
std::vector<Surface> surroundings(const LidarScan& scan, const Cylinder& c,
                                  const PeerMaskSettings& settings) {
  std::vector<Vec3f> points = around(scan, c, settings);
  const float radius_m = c.radius_m;
  Rng rng(0, "peer mask");
  std::vector<Surface> out;
  while (points.size() >= kPointsMin && out.size() < kSurfacesMax) {
    const auto s = surface_of_most(points, kAreaMin * radius_m * radius_m, rng);
    if (!s) break;
    const std::size_t before = points.size();
    std::erase_if(points, [&s](const Vec3f& x) { return s->has(x, kThickness_m); });
    if (before - points.size() < kPointsMin) break;
    out.push_back(*s);
  }
  return out;
}

/// The largest sigma of a level direction.
double level_sigma_m(const KnownLandmark& place, const Vec3& up) {
  const Mat3 level = Mat3::Identity() - up * up.transpose();
  const geometry::Pca3 pca = geometry::pca3(level * place.covariance_m2 * level);
  return std::sqrt(std::max(0.0, pca.values.maxCoeff()));
}

/// Marks the points on one vehicle: within its cylinder, and on no surface that goes on beyond.
void mark(const LidarScan& scan, const Cylinder& c, const PeerMaskSettings& settings,
          std::vector<bool>& on_vehicle) {
  std::vector<std::size_t> inside;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (holds(c, point_of(scan, i), settings)) inside.push_back(i);
  }
  if (inside.empty()) return;
  const std::vector<Surface> surfaces = surroundings(scan, c, settings);
  for (const std::size_t i : inside) {
    const Vec3f x = point_of(scan, i);
    const bool beside = std::any_of(surfaces.begin(), surfaces.end(),
                                    [&x](const Surface& s) { return s.has(x, kThickness_m); });
    if (!beside) on_vehicle[i] = true;
  }
}

/// Marks all that a vehicle at this distance from `p` could be: within the heights of one on the
/// same ground, or on a slope.
void mark_shell(const LidarScan& scan, const Vec3f& p, const Vec3f& up, float range_m,
                const PeerMaskSettings& s, std::vector<bool>& on_vehicle) {
  const auto width_m = static_cast<float>(s.shell_m);
  const float rise_m = static_cast<float>(s.shell_slope) * range_m;
  const float above_m = static_cast<float>(s.above_m) + rise_m;
  const float below_m = static_cast<float>(s.below_m) + rise_m;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const Vec3f d = point_of(scan, i) - p;
    if (std::abs(d.norm() - range_m) > width_m) continue;
    const float height_m = d.dot(up);
    if (height_m < above_m && height_m > -below_m) on_vehicle[i] = true;
  }
}

}  // namespace

std::shared_ptr<const LidarScan> without_peers(
    const LidarScan& scan, const geometry::SE3& T_odom_lidar, const geometry::SE3& T_body_lidar,
    std::span<const KnownLandmark> antennas_odom, std::span<const ReceivedPeer> received,
    const Vec3& up_odom, const PeerMaskSettings& settings) {
  const geometry::SE3 T_lidar_odom = T_odom_lidar.inverse();
  const geometry::SE3 T_lidar_body = T_body_lidar.inverse();
  const Vec3f up = (T_lidar_odom.R * up_odom).cast<float>();
  std::vector<bool> on_vehicle(scan.size(), false);
  for (const KnownLandmark& place : antennas_odom) {
    const double radius_m =
        settings.radius_m + settings.margin_sigma * level_sigma_m(place, up_odom);
    const Cylinder c{(T_lidar_odom * place.p_odom_m).cast<float>(), up,
                     static_cast<float>(radius_m)};
    mark(scan, c, settings, on_vehicle);
  }
  for (const ReceivedPeer& peer : received) {
    if (settings.shell_m <= 0.0 || peer.range_m > settings.shell_far_m) continue;
    const Vec3f p = (T_lidar_body * peer.p_body_antenna_m).cast<float>();
    mark_shell(scan, p, up, static_cast<float>(peer.range_m), settings, on_vehicle);
  }
  if (std::find(on_vehicle.begin(), on_vehicle.end(), true) == on_vehicle.end()) return nullptr;
  auto out = std::make_shared<LidarScan>(scan);  // with all fields besides the points
  for (std::vector<float>* v : {&out->x_m, &out->y_m, &out->z_m, &out->intensity, &out->dt_s}) {
    v->clear();
  }
  out->ring.clear();
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (on_vehicle[i]) continue;
    out->push_back(scan.x_m[i], scan.y_m[i], scan.z_m[i], scan.intensity[i], scan.dt_s[i],
                   scan.ring[i]);
  }
  return out;
}

}  // namespace rali::vehicle
