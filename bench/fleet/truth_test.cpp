#include "truth.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/geometry/so3.hpp"

namespace rali::fleet_bench {
namespace {

using geometry::SE3;
using geometry::Vec3;

constexpr double kRad = 0.1;

SE3 at(double x_m, double y_m = 0.0) { return {geometry::Mat3::Identity(), Vec3(x_m, y_m, 0.0)}; }

/// Both drive 1 m/s along x with a keyframe each metre. The odometry of a vehicle starts `drift_m`
/// to the left and is correct from `good_s` on.
struct Recorded {
  Mission mission;
  Joined joined;

  void add(std::uint16_t vehicle, int from_s, int to_s, double drift_m, int good_s) {
    Driven driven;
    Path path;
    for (int t_s = from_s; t_s <= to_s; ++t_s) {
      driven.truth.push_back({Time::from_s(t_s), at(t_s)});
      drive::KeyframeRecord keyframe;
      keyframe.id = {VehicleId{vehicle}, static_cast<std::uint32_t>(t_s)};
      keyframe.t = Time::from_s(t_s);
      keyframe.T_local_body = at(t_s, t_s < good_s ? drift_m : 0.0);
      path.keyframes.push_back(keyframe);
    }
    mission.vehicles.push_back(driven);
    joined.paths.push_back(path);
  }
};

// The two parts are 0 to 60 s and 40 to 100 s: their overlap is 40 to 60 s.
Recorded halves() {
  Recorded r;
  r.add(0, 0, 60, 0.4, 45);
  r.add(1, 40, 100, 0.0, 0);
  return r;
}

TEST(FrameError, of_vehicles_is_taken_where_each_begins) {
  const Recorded r = halves();
  const auto error = frame_error(r.mission, r.joined, 0, 1, false);
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->distance_m, 0.4, 1e-12);
}

// Odometry errors of the first part before the second began are not an error of the second's frame.
TEST(FrameError, of_halves_is_taken_in_the_middle_of_what_both_have) {
  Recorded r = halves();
  auto error = frame_error(r.mission, r.joined, 0, 1, true);
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->distance_m, 0.0, 1e-12);
  // Rotated about the origin: 5 m at 50 m distance.
  r.joined.paths[1].T_map_odom.R = geometry::rotation_from_rpy(0.0, 0.0, kRad);
  error = frame_error(r.mission, r.joined, 0, 1, true);
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->distance_m, 2.0 * 50.0 * std::sin(0.5 * kRad), 1e-9);
  EXPECT_NEAR(error->angle_rad, kRad, 1e-9);
}

TEST(FrameError, of_halves_with_nothing_in_common_is_that_where_one_ends_and_the_other_begins) {
  Recorded r;
  r.add(0, 0, 40, 0.4, 30);
  r.add(1, 60, 100, 0.0, 0);
  const auto error = frame_error(r.mission, r.joined, 0, 1, true);
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->distance_m, 0.0, 1e-12);
}

TEST(FrameError, of_one_without_keyframes_is_none) {
  Recorded r = halves();
  r.joined.paths[1].keyframes.clear();
  EXPECT_FALSE(frame_error(r.mission, r.joined, 0, 1, true));
  EXPECT_FALSE(frame_error(r.mission, r.joined, 1, 0, true));
}

}  // namespace
}  // namespace rali::fleet_bench
