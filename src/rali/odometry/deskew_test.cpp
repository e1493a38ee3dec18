#include "rali/odometry/deskew.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/base/internal_error.hpp"

namespace rali::odometry {
namespace {

using geometry::SE3;
using geometry::so3_exp;
using geometry::Vec3;

const Vec3 kSpeed(3.0, -1.0, 0.5);
const Vec3 kRate(0.3, -0.2, 2.0);
const SE3 kBodyLidar{so3_exp(Vec3(0.0, 0.1, 0.5)), Vec3(0.2, -0.1, 0.4)};

SE3 body_at(double t_s) { return {so3_exp(t_s * kRate), Vec3(10.0, 5.0, 0.0) + t_s * kSpeed}; }

/// Fixed points of the world, each measured at its own time.
struct Scan {
  sensor::LidarScan scan;
  std::vector<Vec3> world;

  Scan() {
    scan.t_start = Time::from_s(100.0);
    scan.t_end = Time::from_s(100.1);
    scan.has_point_times = true;
    for (int k = 0; k <= 200; ++k) {
      const double dt_s = 0.1 * k / 200;
      const double a = 0.0314 * k;
      world.emplace_back(10.0 + 8.0 * std::cos(a), 5.0 + 6.0 * std::sin(a),
                         2.0 * std::sin(3.0 * a));
      const Vec3 p = (body_at(dt_s) * kBodyLidar).inverse() * world.back();
      scan.push_back(static_cast<float>(p.x()), static_cast<float>(p.y()),
                     static_cast<float>(p.z()), 0.0F, static_cast<float>(dt_s), 0);
    }
  }

  [[nodiscard]] std::vector<TimedPose> poses(double from_s) const {
    std::vector<TimedPose> out;
    for (int k = 0; k <= 20; ++k) {
      const double t_s = from_s + (0.1 - from_s) * k / 20;
      out.push_back({scan.t_start + Duration::from_s(t_s), body_at(t_s)});
    }
    return out;
  }

  /// Largest distance of a deskewed point from its position in the world.
  [[nodiscard]] double worst_error_m(const ScanMotion& motion,
                                     std::span<const std::uint32_t> indices = {}) const {
    BodyPoints out;
    motion.apply(scan, indices, out);
    double worst = 0.0;
    for (std::size_t k = 0; k < out.size(); ++k) {
      const std::size_t i = indices.empty() ? k : indices[k];
      const Vec3 p = body_at(0.1) * Vec3(out.x_m[k], out.y_m[k], out.z_m[k]);
      worst = std::max(worst, (p - world[i]).norm());
      EXPECT_NEAR(out.age_s[k], 0.1 - static_cast<double>(scan.dt_s[i]), 1e-6);
    }
    return worst;
  }
};

TEST(ScanMotion, deskews_every_point_to_within_0_1_mm) {
  const Scan scan;
  // 20 cm and 11 degrees of motion within the scan; the rest is the error of linear tables.
  EXPECT_LT(scan.worst_error_m(ScanMotion(scan.poses(0.0), scan.scan.t_start, kBodyLidar)), 1e-4);
  BodyPoints raw;
  ScanMotion(kBodyLidar).apply(scan.scan, {}, raw);
  const Vec3 first = body_at(0.1) * Vec3(raw.x_m[0], raw.y_m[0], raw.z_m[0]);
  EXPECT_GT((first - scan.world[0]).norm(), 0.5);  // the test would detect a missing correction
}

TEST(ScanMotion, deskews_only_the_requested_points) {
  const Scan scan;
  const std::vector<std::uint32_t> indices{7, 3, 200};
  const ScanMotion motion(scan.poses(0.0), scan.scan.t_start, kBodyLidar);
  BodyPoints out;
  motion.apply(scan.scan, indices, out);
  EXPECT_EQ(out.size(), 3U);
  EXPECT_LT(scan.worst_error_m(motion, indices), 1e-4);
}

TEST(ScanMotion, extrapolates_before_the_first_pose) {
  const Scan scan;
  // Poses start 40 ms late: at a constant rate the extrapolation is exact.
  const ScanMotion motion(scan.poses(0.04), scan.scan.t_start, kBodyLidar);
  EXPECT_LT(scan.worst_error_m(motion), 1e-4);
}

TEST(ScanMotion, ignores_poses_before_the_scan) {
  const Scan scan;
  EXPECT_LT(scan.worst_error_m(ScanMotion(scan.poses(-0.3), scan.scan.t_start, kBodyLidar)), 1e-4);
}

TEST(ScanMotion, applies_only_extrinsics_without_point_times_or_after_deskewing) {
  Scan scan;
  const ScanMotion motion(scan.poses(0.0), scan.scan.t_start, kBodyLidar);
  for (const bool deskewed : {false, true}) {
    scan.scan.has_point_times = deskewed;
    scan.scan.deskewed = deskewed;
    BodyPoints out;
    motion.apply(scan.scan, {}, out);
    for (std::size_t i = 0; i < out.size(); ++i) {
      const Vec3 p = kBodyLidar * Vec3(scan.scan.x_m[i], scan.scan.y_m[i], scan.scan.z_m[i]);
      EXPECT_LT((Vec3(out.x_m[i], out.y_m[i], out.z_m[i]) - p).norm(), 1e-5);
      EXPECT_EQ(out.age_s[i], 0.0F);
    }
  }
}

TEST(ScanMotion, applies_only_extrinsics_with_a_single_pose) {
  const Scan scan;
  const std::vector<TimedPose> one{{scan.scan.t_end, body_at(0.1)}};
  BodyPoints out;
  ScanMotion(one, scan.scan.t_start, kBodyLidar).apply(scan.scan, {}, out);
  const Vec3 p = kBodyLidar * Vec3(scan.scan.x_m[0], scan.scan.y_m[0], scan.scan.z_m[0]);
  EXPECT_LT((Vec3(out.x_m[0], out.y_m[0], out.z_m[0]) - p).norm(), 1e-5);
}

TEST(ScanMotion, stays_finite_with_equal_pose_times_and_hour_long_scans) {
  Scan scan;
  const std::vector<TimedPose> same{{scan.scan.t_end, body_at(0.0)},
                                    {scan.scan.t_end, body_at(0.1)}};
  BodyPoints out;
  ScanMotion(same, scan.scan.t_start, kBodyLidar).apply(scan.scan, {}, out);
  for (const float x : out.x_m) EXPECT_TRUE(std::isfinite(x));
  // An hour: the table stays small, points are still finite.
  scan.scan.t_start = Time::from_s(0.0);
  scan.scan.t_end = Time::from_s(3600.0);
  const std::vector<TimedPose> hour{{Time::from_s(0.0), body_at(0.0)},
                                    {Time::from_s(3600.0), body_at(1.0)}};
  ScanMotion(hour, scan.scan.t_start, kBodyLidar).apply(scan.scan, {}, out);
  for (const float x : out.x_m) EXPECT_TRUE(std::isfinite(x));
  BodyPoints none;
  ScanMotion(kBodyLidar).apply(sensor::LidarScan{}, {}, none);
  EXPECT_EQ(none.size(), 0U);
}

TEST(ScanMotion, throws_an_internal_error_without_poses) {
  EXPECT_THROW(ScanMotion({}, Time{}, kBodyLidar), InternalError);
}

}  // namespace
}  // namespace rali::odometry
