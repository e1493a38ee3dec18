#include "rali/odometry/paper/map_error.hpp"

#include <gtest/gtest.h>

namespace rali::odometry::paper {
namespace {

using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;

SE3 at(double x_m) {
  SE3 T;
  T.p = {x_m, 0.0, 0.0};
  return T;
}

/// Sigmas of 0.01 rad and 0.1 m.
Mat6 good() {
  Mat6 I = Mat6::Zero();
  I.diagonal() << 1e4, 1e4, 1e4, 100.0, 100.0, 100.0;
  return I;
}

TEST(MapError, is_zero_at_the_first_keyframe_and_accumulates_from_there) {
  MapError error;
  error.add_keyframe(at(0.0), good());
  EXPECT_EQ(error.at(at(5.0)).norm(), 0.0);
  error.add_keyframe(at(1.0), good());
  EXPECT_NEAR(error.at(at(1.0))(3, 3), 0.01, 1e-12);
  // 10 m with a heading sigma of 0.01 rad add 0.1 m laterally.
  EXPECT_NEAR(error.at(at(11.0))(4, 4), 0.01 + 0.01, 1e-12);
  EXPECT_NEAR(error.at(at(11.0))(3, 3), 0.01, 1e-12);
  error.add_keyframe(at(11.0), good());
  EXPECT_NEAR(error.at(at(11.0))(4, 4), 0.03, 1e-12);
}

TEST(MapError, excludes_directions_the_registration_does_not_observe) {
  Mat6 I = good();
  I(3, 3) = 0.0;
  MapError error;
  error.add_keyframe(at(0.0), I);
  error.add_keyframe(at(1.0), I);
  EXPECT_NEAR(error.at(at(1.0))(3, 3), 0.0, 1e-12);
  error.add_along(Vec3::UnitX(), 4.0);
  EXPECT_NEAR(error.at(at(1.0))(3, 3), 4.0, 1e-12);
}

TEST(MapError, is_replaced_along_a_direction_measured_by_a_range) {
  MapError error;
  error.add_keyframe(at(0.0), good());
  error.add_along(Vec3::UnitX(), 4.0);
  error.know_along(Vec3::UnitX(), 0.2);
  EXPECT_NEAR(error.at(at(0.0))(3, 3), 0.04, 1e-12);
}

TEST(MapError, exceeds_1_m_after_tracking_is_lost) {
  MapError error;
  error.add_keyframe(at(0.0), good());
  error.lose();
  EXPECT_GT(std::sqrt(error.at(at(0.0))(3, 3)), 1.0);
}

}  // namespace
}  // namespace rali::odometry::paper
