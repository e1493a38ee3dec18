#include "rali/sim/lidar_model.hpp"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

namespace rali::sim {
namespace {

using geometry::Vec3;

double degrees(double rad) { return rad * 180.0 / M_PI; }

void expect_angles(Lidar kind, const std::vector<double>& table_deg, double tolerance_deg) {
  const std::vector<double> rings = LidarModel(kind).elevations_rad();
  ASSERT_EQ(rings.size(), table_deg.size());
  for (std::size_t i = 0; i < rings.size(); ++i) {
    EXPECT_NEAR(degrees(rings[i]), table_deg[i], tolerance_deg) << "ring " << i;
  }
}

// The tables are typed from the makers' manuals, lowest first; manuals round to 0.01 deg.
TEST(LidarModel, rings_of_rs16_and_vlp16_are_at_odd_degrees) {
  const std::vector<double> odd = {-15, -13, -11, -9, -7, -5, -3, -1, 1, 3, 5, 7, 9, 11, 13, 15};
  expect_angles(Lidar::kRs16, odd, 1e-5);
  expect_angles(Lidar::kVlp16, odd, 1e-5);
}

TEST(LidarModel, rings_of_hdl32e_match_the_manual) {
  expect_angles(Lidar::kHdl32e, {-30.67, -29.33, -28.00, -26.67, -25.33, -24.00, -22.67, -21.33,
                                 -20.00, -18.67, -17.33, -16.00, -14.67, -13.33, -12.00, -10.67,
                                 -9.33,  -8.00,  -6.67,  -5.33,  -4.00,  -2.67,  -1.33,  0.00,
                                 1.33,   2.67,   4.00,   5.33,   6.67,   8.00,   9.33,   10.67},
                0.01);
}

TEST(LidarModel, rings_of_hdl64e_have_two_blocks) {
  std::vector<double> table;
  for (int i = 0; i < 32; ++i) table.push_back(-24.33 + 0.5 * i);  // lower block
  for (int i = 0; i < 32; ++i) table.push_back(-8.33 + i / 3.0);   // upper block, to +2 deg
  expect_angles(Lidar::kHdl64e, table, 0.01);
}

TEST(LidarModel, rings_of_os1_64_match_the_manufacturer_defaults) {
  const std::vector<double> rings = LidarModel(Lidar::kOs1_64).elevations_rad();
  ASSERT_EQ(rings.size(), 64U);
  const std::vector<double> top = {16.611, 16.084, 15.557, 15.029, 14.502, 13.975, 13.447, 12.920};
  for (std::size_t i = 0; i < top.size(); ++i) {
    EXPECT_NEAR(degrees(rings[63 - i]), top[i], 1e-3);
    EXPECT_NEAR(degrees(rings[i]), -top[i], 1e-3);
  }
  EXPECT_NEAR(degrees(rings[32]), 0.264, 1e-3);
}

TEST(LidarModel, rings_of_os0_128_span_90_deg) {
  const std::vector<double> rings = LidarModel(Lidar::kOs0_128).elevations_rad();
  ASSERT_EQ(rings.size(), 128U);
  EXPECT_NEAR(degrees(rings.front()), -45.0, 1.5);  // units differ
  EXPECT_NEAR(degrees(rings.back()), 45.0, 1.5);
  for (std::size_t i = 1; i < rings.size(); ++i) {
    EXPECT_NEAR(degrees(rings[i] - rings[i - 1]), 0.7, 0.07);
  }
}

TEST(LidarModel, lasers_of_vlp16_fire_alternately_low_and_high_every_2304_ns) {
  const LidarModel vlp(Lidar::kVlp16);
  // Elevations of laser 0, 1, 2, ... of the manual.
  const std::vector<double> manual = {-15, 1, -13, 3, -11, 5, -9, 7, -7, 9, -5, 11, -3, 13, -1, 15};
  for (std::size_t k = 0; k < manual.size(); ++k) {
    const int ring = vlp.order()[k];
    EXPECT_NEAR(degrees(vlp.elevations_rad()[static_cast<std::size_t>(ring)]), manual[k], 1e-5);
    EXPECT_NEAR(vlp.phase(ring) * 1e6 * vlp.scan_s() / vlp.firings(),
                2.304 * static_cast<double>(k), 1e-9);
  }
}

TEST(LidarModel, channels_of_rs16_fire_upwards_then_downwards_every_2800_ns) {
  const LidarModel rs(Lidar::kRs16);
  const std::vector<double> manual = {-15, -13, -11, -9, -7, -5, -3, -1, 15, 13, 11, 9, 7, 5, 3, 1};
  for (std::size_t k = 0; k < manual.size(); ++k) {
    const int ring = rs.order()[k];
    EXPECT_NEAR(degrees(rs.elevations_rad()[static_cast<std::size_t>(ring)]), manual[k], 1e-5);
    EXPECT_NEAR(rs.phase(ring) * 1e6 * rs.scan_s() / rs.firings(), 2.8 * static_cast<double>(k),
                1e-9);
  }
}

TEST(LidarModel, firing_order_of_hdl32e_matches_the_manual) {
  const LidarModel hdl(Lidar::kHdl32e);
  const std::vector<double> manual = {-30.67, -9.33, -29.33, -8.00, -28.00, -6.67};
  for (std::size_t k = 0; k < manual.size(); ++k) {
    const int ring = hdl.order()[k];
    EXPECT_NEAR(degrees(hdl.elevations_rad()[static_cast<std::size_t>(ring)]), manual[k], 0.01);
  }
  EXPECT_NEAR(1e6 * hdl.scan_s() / hdl.firings(), 46.08, 0.01);
}

TEST(LidarModel, every_ring_fires_once_within_its_period) {
  for (std::size_t k = 0; k < kLidarNames.size(); ++k) {
    const LidarModel model(static_cast<Lidar>(k));
    const std::set<int> rings(model.order().begin(), model.order().end());
    EXPECT_EQ(static_cast<int>(rings.size()), model.rings());
    for (int r = 0; r < model.rings(); ++r) {
      EXPECT_GE(model.phase(r), 0.0);
      EXPECT_LT(model.phase(r), 1.0);
    }
  }
}

TEST(LidarModel, beams_have_their_elevation_and_rotate_clockwise) {
  for (const Lidar kind : {Lidar::kRs16, Lidar::kHdl64e, Lidar::kOs1_64, Lidar::kOs0_128}) {
    const LidarModel model(kind);
    for (int ring = 0; ring < model.rings(); ++ring) {
      const Vec3 first = model.beam(ring, 0, 0).cast<double>();
      const Vec3 later = model.beam(ring, model.firings() / 4, 0).cast<double>();
      EXPECT_NEAR(std::asin(first.z()), model.elevations_rad()[static_cast<std::size_t>(ring)],
                  1e-6);
      const double turned = std::remainder(
          std::atan2(later.y(), later.x()) - std::atan2(first.y(), first.x()), 2.0 * M_PI);
      EXPECT_NEAR(turned, -M_PI / 2.0, 0.01);
    }
  }
}

TEST(LidarModel, beam_azimuths_of_os1_64_repeat_every_four_rings) {
  const LidarModel os(Lidar::kOs1_64);
  const std::vector<double> lateral = {3.164, 1.055, -1.055, -3.164};  // beam_azimuth_angles
  for (int ring = 0; ring < 8; ++ring) {
    const Vec3 d = os.beam(ring, 0, 0).cast<double>();
    EXPECT_NEAR(degrees(std::atan2(d.y(), d.x())), lateral[static_cast<std::size_t>(ring % 4)],
                1e-3);
  }
}

TEST(LidarModel, the_livox_rosette_does_not_repeat_and_fills_its_cone) {
  const LidarModel livox(Lidar::kLivox);
  const Vec3 first = livox.beam(0, 100, 0).cast<double>();
  const Vec3 later = livox.beam(0, 100, 1).cast<double>();
  EXPECT_NEAR(first.norm(), 1.0, 1e-6);
  EXPECT_GT((first - later).norm(), 0.01);
  const auto covered = [&](int scans) {
    std::set<std::pair<int, int>> cells;  // of 1 deg
    for (int scan = 0; scan < scans; ++scan) {
      for (int firing = 0; firing < livox.firings(); ++firing) {
        const Vec3 d = livox.beam(3, firing, scan).cast<double>();
        EXPECT_GT(d.x(), 0.8);  // within 36 deg of the axis
        cells.emplace(static_cast<int>(std::floor(degrees(std::atan2(d.y(), d.x())))),
                      static_cast<int>(std::floor(degrees(std::asin(d.z())))));
      }
    }
    return cells.size();
  };
  const double cone = M_PI * 35.0 * 35.0;
  const auto one = static_cast<double>(covered(1));
  const auto ten = static_cast<double>(covered(10));
  EXPECT_GT(ten, 1.2 * one);
  EXPECT_GT(ten, 0.8 * cone);
}

}  // namespace
}  // namespace rali::sim
