#include "rali/fleet/centre/scan_evidence.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/fleet/centre/pieces_for_test.hpp"

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

/// Two paths of one node; a comparison saw the second 2 m ahead of the first, to 1 cm.
class Agrees : public ::testing::Test {
 protected:
  [[nodiscard]] bool at(const geometry::SE3& T_map_odom) {
    frames_.T_map_odom = {geometry::SE3{}, T_map_odom};
    return agrees(paths_, pieces_, found_, frames_, InitSettings{});
  }

  static geometry::SE3 placed(double x_m, double y_m, double yaw_rad = 0.0) {
    return {geometry::rotation_from_rpy(0.0, 0.0, yaw_rad), {x_m, y_m, 0.0}};
  }

  std::vector<VehiclePath> paths_ = {standing(1), standing(2)};
  std::vector<PathSubmap> pieces_ = {piece_of(paths_[0], 0, 0), piece_of(paths_[1], 1, 0)};
  LoopFound found_ = seen_at({2.0, 0.0, 0.0}, 0, 1, 0.01);
  PathFrames frames_{{{0, 1}}, {0, 0}, {}, {"", "scans"}};
};

// 1 cm and the drift of nothing: 16 is 4 sigma, 4 cm.
TEST_F(Agrees, with_frames_that_have_it_where_it_was_seen) {
  EXPECT_TRUE(at(placed(2.0, 0.0)));
  EXPECT_TRUE(at(placed(2.03, 0.0)));
  EXPECT_FALSE(at(placed(2.05, 0.0)));
  EXPECT_FALSE(at(placed(2.0, 0.0, 0.1)));
  EXPECT_FALSE(at(placed(-2.0, 0.0)));
}

TEST_F(Agrees, along_what_it_does_not_claim_with_anything) {
  found_.recognition.certainty = places::Certainty::kAlongAxis;
  found_.recognition.placements.front().registration.information(3, 3) = 0.0;
  EXPECT_TRUE(at(placed(7.0, 0.0)));
  EXPECT_FALSE(at(placed(7.0, 0.1)));
}

TEST_F(Agrees, not_if_it_has_rivals_or_is_no_placement_or_frames_are_apart) {
  found_.recognition.certainty = places::Certainty::kAmbiguous;
  EXPECT_FALSE(at(placed(2.0, 0.0)));
  found_.recognition.certainty = places::Certainty::kUnique;
  frames_.group = {0, 1};
  EXPECT_FALSE(at(placed(2.0, 0.0)));
  frames_.group = {0, 0};
  found_.recognition.placements.clear();
  EXPECT_FALSE(at(placed(2.0, 0.0)));
}

TEST_F(Agrees, not_with_what_is_no_number) { EXPECT_FALSE(at(placed(std::nan(""), 0.0))); }

}  // namespace
}  // namespace rali::fleet
