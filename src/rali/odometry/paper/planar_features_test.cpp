#include "rali/odometry/paper/planar_features.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/geometry/types.hpp"

namespace rali::odometry::paper {
namespace {

using geometry::Vec3f;
using sensor::LidarScan;

constexpr float kPi = std::numbers::pi_v<float>;

void add(LidarScan& scan, float x, float y, float z, int ring) {
  scan.push_back(x, y, z, 0.0F, 0.0F, static_cast<std::uint16_t>(ring));
}

Vec3f normal(const PlanarFeatures& f, std::size_t i) { return {f.nx[i], f.ny[i], f.nz[i]}; }

// Five points on the wall x = 5: one candidate, its two ring neighbours, one above, one below.
// Each lies in its own cube.
LidarScan five_points() {
  LidarScan scan;
  add(scan, 5.1F, 0.1F, -0.3F, 0);
  add(scan, 5.1F, -0.2F, 0.1F, 1);
  add(scan, 5.1F, 0.1F, 0.1F, 1);
  add(scan, 5.1F, 0.3F, 0.1F, 1);
  add(scan, 5.1F, 0.1F, 0.3F, 2);
  return scan;
}

PlanarFeatures features_of(const LidarScan& scan, const PlanarFeatureSettings& settings = {}) {
  PlanarFeatures out;
  extract_planar_features(scan, settings, out);
  return out;
}

TEST(PlanarFeatures, five_points_on_a_wall_give_its_normal_towards_the_sensor) {
  LidarScan scan = five_points();
  scan.z_m[0] = -0.25F;
  const PlanarFeatures f = features_of(scan);
  ASSERT_EQ(f.size(), 1U);
  EXPECT_EQ(f.x_m[0], 5.1F);
  EXPECT_EQ(f.y_m[0], 0.1F);
  EXPECT_LT((normal(f, 0) - Vec3f(-1.0F, 0.0F, 0.0F)).norm(), 1e-6F);
}

// Upper half tilted by 4 deg, lower half by -4 deg: n_G and n_O are 8 deg apart, their sum is the
// wall's normal again. Worked by hand: dx = 0.2 tan 4 deg = 0.013985 at both ends.
TEST(PlanarFeatures, average_two_normals_that_agree_within_the_angle) {
  LidarScan scan = five_points();
  scan.x_m[0] = 5.1F + 0.35F * std::tan(4.0F * kPi / 180.0F);
  scan.z_m[0] = -0.25F;
  scan.x_m[4] = 5.1F + 0.2F * std::tan(4.0F * kPi / 180.0F);
  PlanarFeatureSettings settings;
  settings.theta_planar_deg = 8.1;
  const PlanarFeatures f = features_of(scan, settings);
  ASSERT_EQ(f.size(), 1U);
  EXPECT_LT((normal(f, 0) - Vec3f(-1.0F, 0.0F, 0.0F)).norm(), 1e-5F);
  settings.theta_planar_deg = 7.9;
  EXPECT_EQ(features_of(scan, settings).size(), 0U);
}

TEST(PlanarFeatures, rejects_a_candidate_without_a_ring_above_or_below) {
  for (const int missing : {0, 4}) {
    LidarScan scan;
    const LidarScan full = five_points();
    for (int i = 0; i < 5; ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (i != missing) add(scan, full.x_m[k], full.y_m[k], full.z_m[k], full.ring[k]);
    }
    EXPECT_EQ(features_of(scan).size(), 0U) << "without point " << missing;
  }
}

TEST(PlanarFeatures, rejects_neighbours_further_than_twice_the_resolution) {
  LidarScan above = five_points();
  above.z_m[4] = 0.1F + 0.401F;
  EXPECT_EQ(features_of(above).size(), 0U);
  LidarScan beside = five_points();
  beside.y_m[3] = 0.1F + 0.401F;
  EXPECT_EQ(features_of(beside).size(), 0U);
}

TEST(PlanarFeatures, rejects_a_candidate_alone_on_its_ring) {
  LidarScan scan;
  add(scan, 5.1F, 0.1F, -0.1F, 0);
  add(scan, 5.1F, 0.1F, 0.1F, 1);
  add(scan, 5.1F, 0.1F, 0.3F, 2);
  EXPECT_EQ(features_of(scan).size(), 0U);
}

TEST(PlanarFeatures, use_the_next_available_ring_when_rings_are_missing) {
  LidarScan scan = five_points();
  scan.z_m[0] = -0.25F;
  for (auto& r : scan.ring) r = static_cast<std::uint16_t>(4 * r);  // rings 0, 4, 8
  EXPECT_EQ(features_of(scan).size(), 1U);
}

TEST(PlanarFeatures, neighbours_are_found_across_the_azimuth_wrap_around) {
  LidarScan scan;  // the wall x = +5 has azimuth 0 in its middle: y < 0 comes last
  for (int ring = 0; ring < 3; ++ring) {
    for (int k = -4; k <= 4; ++k) {
      add(scan, 5.1F, 0.1F + 0.25F * static_cast<float>(k), 0.1F + 0.25F * static_cast<float>(ring),
          ring);
    }
  }
  EXPECT_EQ(features_of(scan).size(), 7U);  // all of the middle ring but its two ends
}

// A 16-ring scan in a box: every feature lies on a wall, floor or ceiling and has its normal.
LidarScan box_scan(float noise_m, float half_x = 4.0F, float half_y = 3.0F, float low = -0.8F,
                   float high = 2.0F) {
  LidarScan scan;
  Rng rng(5);
  for (int a = 0; a < 1800; ++a) {
    for (int ring = 0; ring < 16; ++ring) {
      const float elevation = static_cast<float>(-15 + 2 * ring) * kPi / 180.0F;
      const float azimuth = static_cast<float>(a) * 0.2F * kPi / 180.0F;
      const Vec3f d(std::cos(elevation) * std::cos(azimuth),
                    std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      const float tx = half_x / std::max(1e-6F, std::abs(d.x()));
      const float ty = half_y / std::max(1e-6F, std::abs(d.y()));
      const float tz = (d.z() > 0 ? high : low) / (std::abs(d.z()) < 1e-6F ? 1e-6F : d.z());
      const float r = std::min({tx, ty, std::abs(tz)}) + noise_m * static_cast<float>(rng.normal());
      add(scan, r * d.x(), r * d.y(), r * d.z(), ring);
    }
  }
  return scan;
}

// The side of the box that p lies on, none within 0.4 m of an edge. There the chord spans both
// sides, and as both cross products contain it they agree on a wrong normal: the paper's rule does
// not detect vertical edges.
Vec3f side_normal(const Vec3f& p) {
  const Vec3f to_side(4.0F - std::abs(p.x()), 3.0F - std::abs(p.y()),
                      std::min(2.0F - p.z(), p.z() + 0.8F));
  Vec3f::Index axis = 0;
  to_side.minCoeff(&axis);
  if ((to_side.array() < 0.41F).count() != 1) return Vec3f::Zero();
  Vec3f n = Vec3f::Zero();
  n(axis) = p(axis) > 0.0F ? -1.0F : 1.0F;
  return n;
}

TEST(PlanarFeatures, of_a_clean_box_have_the_normals_of_its_sides) {
  const PlanarFeatures f = features_of(box_scan(0.0F));
  ASSERT_GT(f.size(), 300U);
  std::size_t compared = 0;
  for (std::size_t i = 0; i < f.size(); ++i) {
    const Vec3f p(f.x_m[i], f.y_m[i], f.z_m[i]);
    EXPECT_LT(normal(f, i).dot(p), 0.0F) << "not turned to the sensor";
    EXPECT_NEAR(normal(f, i).norm(), 1.0F, 1e-5F);
    const Vec3f expected = side_normal(p);
    if (expected.isZero()) continue;
    ++compared;
    EXPECT_LT((normal(f, i) - expected).norm(), 1e-3F);
  }
  EXPECT_GT(compared, f.size() / 2);
}

TEST(PlanarFeatures, do_not_depend_on_the_order_of_columns) {
  const LidarScan scan = box_scan(0.02F);
  LidarScan ring_major;
  for (int ring = 0; ring < 16; ++ring) {
    for (std::size_t i = 0; i < scan.size(); ++i) {
      if (scan.ring[i] == ring) add(ring_major, scan.x_m[i], scan.y_m[i], scan.z_m[i], ring);
    }
  }
  const PlanarFeatures a = features_of(scan);
  const PlanarFeatures b = features_of(ring_major);
  EXPECT_EQ(a.x_m, b.x_m);
  EXPECT_EQ(a.nx, b.nx);
  EXPECT_EQ(a.turned, b.turned);
}

TEST(PlanarFeatures, of_a_reused_extractor_are_those_of_a_fresh_one) {
  PlanarFeatureExtractor extractor;
  PlanarFeatures first;
  const LidarScan room = box_scan(0.02F);
  extractor.extract(view_of(box_scan(0.02F, 20.0F, 1.2F)), {}, first);
  extractor.extract(view_of(room), {}, first);
  const PlanarFeatures fresh = features_of(room);
  EXPECT_EQ(first.x_m, fresh.x_m);
  EXPECT_EQ(first.nz, fresh.nz);
}

TEST(PlanarFeatures, raw_normals_have_mixed_signs_before_orientation_to_the_sensor) {
  const PlanarFeatures f = features_of(box_scan(0.02F));
  std::size_t turned = 0;
  for (const std::uint8_t t : f.turned) turned += t;
  EXPECT_GT(turned, f.size() / 10);
  EXPECT_LT(turned, f.size() - f.size() / 10);
}

TEST(PlanarFeatures, are_empty_for_empty_or_non_finite_scans) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  EXPECT_EQ(features_of(LidarScan{}).size(), 0U);
  LidarScan one;
  add(one, 1.0F, 2.0F, 3.0F, 65535);
  EXPECT_EQ(features_of(one).size(), 0U);
  LidarScan rubbish;
  for (int k = 0; k < 300; ++k) {
    add(rubbish, k % 3 == 0 ? nan : inf, k % 2 == 0 ? -inf : 1e30F, k % 5 == 0 ? nan : 0.0F, k % 4);
    add(rubbish, 0.0F, 0.0F, 0.0F, k % 4);
  }
  EXPECT_EQ(features_of(rubbish).size(), 0U);
}

TEST(PlanarFeatures, are_not_changed_by_interspersed_nan_points) {
  const LidarScan clean = box_scan(0.02F);
  LidarScan dirty;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t i = 0; i < clean.size(); ++i) {
    add(dirty, clean.x_m[i], clean.y_m[i], clean.z_m[i], clean.ring[i]);
    if (i % 7 == 0) add(dirty, nan, clean.y_m[i], clean.z_m[i], clean.ring[i]);
  }
  EXPECT_EQ(features_of(clean).x_m, features_of(dirty).x_m);
}

}  // namespace
}  // namespace rali::odometry::paper
