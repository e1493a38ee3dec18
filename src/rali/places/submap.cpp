#include "rali/places/submap.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "rali/cloud/voxel_sampler.hpp"

namespace rali::places {

using geometry::SE3;
using geometry::Vec3;
using geometry::Vec3f;

namespace {

constexpr double kFarthest_m = 1e5;  // a pose beyond this is invalid

tl::unexpected<Error> refused(std::string what) {
  return fail(ErrorCode::kInput, "submap", std::move(what));
}

bool usable(const SE3& T) {
  return T.R.allFinite() && T.p.allFinite() && T.p.cwiseAbs().maxCoeff() < kFarthest_m &&
         (T.R * T.R.transpose() - geometry::Mat3::Identity()).cwiseAbs().maxCoeff() < 1e-3;
}

Status check(std::span<const PosedScan> scans, std::size_t middle) {
  if (scans.empty()) return refused("there is no scan");
  if (middle >= scans.size()) return refused("the middle scan is not among the scans");
  for (const PosedScan& s : scans) {
    const Scan& scan = s.scan;
    if (!usable(s.T_odom_body) || !usable(scan.T_body_lidar)) {
      return refused("a pose is not a rigid motion of finite numbers");
    }
    if (!scan.up_body.allFinite() || std::abs(scan.up_body.norm() - 1.0) > 1e-3) {
      return refused("an up direction is not a unit vector");
    }
    if (scan.y_m.size() != scan.x_m.size() || scan.z_m.size() != scan.x_m.size()) {
      return refused("coordinates of a scan differ in number");
    }
  }
  return {};
}

/// Levels the body by the smallest rotation; its x axis, seen from above, stays.
geometry::Mat3 levelled(const Vec3& up_body) {
  const geometry::Mat3 R = geometry::rotation_between(up_body, Vec3::UnitZ());
  const Vec3 x = R.col(0);
  return geometry::so3_exp(Vec3(0.0, 0.0, -std::atan2(x.y(), x.x()))) * R;
}

/// The points of all scans, one scan after the other.
struct Gathered {
  std::vector<Vec3f> points;
  std::vector<Vec3f> origins;     ///< of the rays, per scan
  std::vector<std::size_t> ends;  ///< of the points, per scan

  /// Views of this: it must outlive them.
  [[nodiscard]] std::vector<Look> looks() const;
};

Gathered gather(std::span<const PosedScan> scans, const SE3& T_ref_odom, const SubmapSettings& s) {
  Gathered out;
  std::size_t total = 0;
  for (const PosedScan& posed : scans) total += posed.scan.size();
  const std::size_t stride = total / static_cast<std::size_t>(s.points_max) + 1;
  out.points.reserve(total / stride + 1);
  std::size_t number = 0;
  for (const PosedScan& posed : scans) {
    const SE3 T_ref_body = T_ref_odom * posed.T_odom_body;
    for (std::size_t i = 0; i < posed.scan.size(); ++i, ++number) {
      if (number % stride != 0) continue;
      const Vec3 p = posed.scan.point_body(i);
      const double range_m = (p - posed.scan.T_body_lidar.p).norm();
      if (!(range_m < s.range_max_m)) continue;  // also NaN
      out.points.push_back((T_ref_body * p).cast<float>());
    }
    out.ends.push_back(out.points.size());
    out.origins.push_back((T_ref_body * posed.scan.T_body_lidar.p).cast<float>());
  }
  return out;
}

std::vector<Look> Gathered::looks() const {
  std::vector<Look> looks;
  std::size_t begin = 0;
  for (std::size_t k = 0; k < ends.size(); ++k) {
    looks.push_back({origins[k], std::span(points).subspan(begin, ends[k] - begin)});
    begin = ends[k];
  }
  return looks;
}

/// Directions from the sensor to each point.
std::vector<Vec3f> rays_of(std::span<const Look> looks) {
  std::vector<Vec3f> rays;
  for (const Look& look : looks) {
    for (const Vec3f& p : look.points) {
      const Vec3f d = p - look.origin;
      const float length = d.norm();
      rays.push_back(length > 0.0F ? Vec3f(d / length) : Vec3f(0.0F, 0.0F, 1.0F));
    }
  }
  return rays;
}

}  // namespace

/// In steps of 2 mm, or larger ones if a coordinate needs more than 16 bits.
void Submap::keep(std::span<const Vec3f> points) {
  constexpr float kStep_m = 0.002F, kMost = 32767.0F;
  float farthest_m = 0.0F;
  for (const Vec3f& p : points) farthest_m = std::max(farthest_m, p.cwiseAbs().maxCoeff());
  step_m_ = std::max(kStep_m, farthest_m / kMost);
  points_.reserve(points.size());
  for (const Vec3f& p : points) {
    Packed packed;
    for (int k = 0; k < 3; ++k) {
      const float steps = std::clamp(std::round(p[k] / step_m_), -kMost, kMost);
      packed[static_cast<std::size_t>(k)] = static_cast<std::int16_t>(steps);
    }
    points_.push_back(packed);
  }
}

/// One point per cube, with the plane it is on.
void Submap::choose_checks(std::span<const Vec3f> points, double spacing_m) {
  cloud::VoxelSampler sampler;
  std::vector<float> x(points.size()), y(points.size()), z(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    x[i] = points[i].x();
    y[i] = points[i].y();
    z[i] = points[i].z();
  }
  std::vector<std::uint32_t> chosen;
  sampler.sample({x.data(), y.data(), z.data(), x.size()}, {}, spacing_m, chosen);
  checks_.reserve(chosen.size());
  for (const std::uint32_t i : chosen) {
    CheckPoint check;
    check.p_m = points[i];
    const Vec3 p_m = points[i].cast<double>();
    check.solid = free_space_.look(p_m) != Sight::kLoose;
    double best_m = 0.1;  // a point nearer to a plane than this is on it
    plane_index_.near(p_m, 0.5, [&](std::uint32_t k) {
      const Plane& plane = planes_[k];
      const Vec3 d = p_m - plane.q_m;
      if (d.squaredNorm() > plane.radius_m * plane.radius_m) return;
      const double off_m = std::abs(plane.n.dot(d));
      if (off_m >= best_m) return;
      best_m = off_m;
      check.n = plane.n.cast<float>();
      check.upright = plane.is_wall();
    });
    checks_.push_back(check);
  }
}

/// The lowest level surface with enough of the points that face up.
void Submap::find_ground() {
  std::vector<std::pair<double, int>> levels;
  int all = 0;
  for (const Plane& plane : planes_) {
    if (plane.n.z() < 0.95) continue;
    levels.emplace_back(plane.q_m.z(), plane.points);
    all += plane.points;
  }
  std::sort(levels.begin(), levels.end());
  constexpr double kFraction =
      0.3;  // a ditch or a stray plane below has less; a table is above the ground
  double below = 0.0;
  for (const auto& [z_m, points] : levels) {
    below += points;
    if (below < kFraction * all) continue;
    ground_z_m_ = z_m;
    return;
  }
}

Result<Submap> make_submap(std::span<const PosedScan> scans, std::size_t middle,
                           const SubmapSettings& settings) {
  if (auto ok = check(scans, middle); !ok) return tl::make_unexpected(ok.error());
  const PosedScan& center = scans[middle];
  Submap out;
  out.middle_ = center.scan.id;
  out.T_ref_body_.R = levelled(center.scan.up_body);
  for (std::size_t k = 0; k < scans.size(); ++k) {
    out.scans_.push_back(scans[k].scan.id);
    if (k > 0) out.path_m_ += (scans[k].T_odom_body.p - scans[k - 1].T_odom_body.p).norm();
  }
  const Gathered seen = gather(scans, out.T_ref_body_ * center.T_odom_body.inverse(), settings);
  if (seen.points.empty()) return refused("no scan has a usable point");
  const std::vector<Look> looks = seen.looks();
  out.views_ = seen.origins;
  out.free_space_.build(looks, settings.free_space);
  out.planes_ = planes_of(seen.points, rays_of(looks), settings.plane);
  std::vector<Vec3> means;
  means.reserve(out.planes_.size());
  for (const Plane& plane : out.planes_) means.push_back(plane.q_m);
  out.plane_index_.build(means, settings.plane.cell_m);
  out.choose_checks(seen.points, settings.check_m);
  out.find_ground();
  out.keep(seen.points);
  return out;
}

}  // namespace rali::places
