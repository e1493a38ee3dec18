#include "rali/fleet/centre/scan_evidence.hpp"

#include <gtest/gtest.h>

namespace rali::fleet {
namespace {

using geometry::Mat6;
using geometry::Vec3;

/// Heading to 1 mrad and place to 1 cm, but for one direction: along it only the combination of
/// place and heading that a point `arm_m` ahead keeps is unknown.
Mat6 blind_along(const Vec3& axis, double yaw_per_m) {
  geometry::Vec6 u;
  u << 0.0, 0.0, yaw_per_m, axis;
  Mat6 I = Mat6::Zero();
  I.diagonal() << 1e6, 1e6, 1e6, 1e4, 1e4, 1e4;
  const geometry::Vec6 Iu = I * u;
  return I - Iu * Iu.transpose() / u.dot(Iu);
}

TEST(Slide, is_what_leads_along_the_direction_that_is_not_known) {
  EXPECT_NEAR(slide_m(blind_along(Vec3::UnitX(), 0.0), {3.0, 0.4, 0.0}), 3.0, 1e-6);
  EXPECT_NEAR(slide_m(blind_along(Vec3::UnitY(), 0.0), {3.0, 0.4, 0.0}), 0.4, 1e-6);
}

// In a bend the place along it and the heading go together: the block of places alone looks as if
// all were known.
TEST(Slide, of_a_direction_that_is_tied_to_heading_is_seen) {
  const Mat6 I = blind_along(Vec3::UnitX(), 0.01);
  EXPECT_GT(I(3, 3), 1.0);
  EXPECT_NEAR(slide_m(I, {3.0, 0.0, 0.0}), 3.0, 1e-3);
}

TEST(Slide, of_a_loop_that_claims_all_is_none_and_of_one_that_claims_nothing_all) {
  Mat6 I = Mat6::Identity();
  I *= 1e4;
  EXPECT_EQ(slide_m(I, {5.0, 5.0, 5.0}), 0.0);
  EXPECT_NEAR(slide_m(Mat6::Zero(), {3.0, 4.0, 0.0}), 5.0, 1e-9);
}

}  // namespace
}  // namespace rali::fleet
