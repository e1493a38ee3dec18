#include "rali/fleet/centre/scan_evidence.hpp"

#include <cmath>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "rali/fleet/centre/pieces_for_test.hpp"

namespace rali::fleet {
namespace {

using geometry::Mat6;
using geometry::Vec3;

/// Heading to 1 mrad and position to 1 cm, except for one direction: along it the coupled motion of
/// position and heading about a point `arm_m` ahead is unobservable.
Mat6 degenerate_along(const Vec3& axis, double yaw_per_m) {
  geometry::Vec6 u;
  u << 0.0, 0.0, yaw_per_m, axis;
  Mat6 I = Mat6::Zero();
  I.diagonal() << 1e6, 1e6, 1e6, 1e4, 1e4, 1e4;
  const geometry::Vec6 Iu = I * u;
  return I - Iu * Iu.transpose() / u.dot(Iu);
}

TEST(Slide, is_the_displacement_along_the_degenerate_direction) {
  EXPECT_NEAR(slide_m(degenerate_along(Vec3::UnitX(), 0.0), {3.0, 0.4, 0.0}), 3.0, 1e-6);
  EXPECT_NEAR(slide_m(degenerate_along(Vec3::UnitY(), 0.0), {3.0, 0.4, 0.0}), 0.4, 1e-6);
}

// In a bend the position along it and the heading are coupled: the position block alone looks as if
// all directions were observable.
TEST(Slide, includes_a_degenerate_direction_coupled_with_heading) {
  const Mat6 I = degenerate_along(Vec3::UnitX(), 0.01);
  EXPECT_GT(I(3, 3), 1.0);
  EXPECT_NEAR(slide_m(I, {3.0, 0.0, 0.0}), 3.0, 1e-3);
}

TEST(Slide, is_zero_with_full_information_and_complete_with_zero_information) {
  Mat6 I = Mat6::Identity();
  I *= 1e4;
  EXPECT_EQ(slide_m(I, {5.0, 5.0, 5.0}), 0.0);
  EXPECT_NEAR(slide_m(Mat6::Zero(), {3.0, 4.0, 0.0}), 5.0, 1e-9);
}

TEST(Bend, widens_lateral_and_yaw_sigma_in_proportion_to_the_degenerate_uncertainty) {
  const Mat6 I = degenerate_along(Vec3::UnitX(), 0.0);
  const geometry::Mat3 place_m2 = Vec3(9.0, 9.0, 9.0).asDiagonal();
  const Mat6 bent = with_bend(I, place_m2, 0.01, 0.0);
  EXPECT_NEAR(1.0 / bent(4, 4), 1e-4 + 9e-4, 1e-6) << "1 cm, and 1 % of 3 m";
  EXPECT_NEAR(1.0 / bent(2, 2), 1e-6 + 9e-4, 1e-6);
  EXPECT_NEAR(bent(3, 3), 0.0, 1e-9) << "nothing is learned along it";
}

// Two places 28 m apart in an inclined bend: the direction that their comparison left open was 0.06
// rad off, so a centimetre across seemed to measure 0.5 m along it.
TEST(Bend, widens_the_lateral_sigma_with_the_distance_between_the_bodies) {
  const Mat6 I = degenerate_along(Vec3::UnitX(), 0.0);
  const geometry::Mat3 place_m2 = Vec3(9.0, 9.0, 9.0).asDiagonal();
  const Mat6 bent = with_bend(I, place_m2, 0.01, 20.0);
  EXPECT_NEAR(1.0 / bent(4, 4), 1e-4 + 401.0 * 9e-4, 1e-3) << "3 m along, 0.2 rad off";
  EXPECT_NEAR(1.0 / bent(2, 2), 1e-6 + 9e-4, 1e-6) << "the heading differs by the slide alone";
}

TEST(Bend, of_a_loop_grows_with_the_distance_of_its_bodies) {
  const VehiclePath path = straight_path(1);
  const std::vector<PathSubmap> pieces = {piece_of(path, 0, 2), piece_of(path, 0, 8)};
  const auto lateral_sigma_m = [&pieces](double apart_m) {
    LoopFound found = seen_at({apart_m, 0.0, 0.0}, 0, 1, 0.01);
    found.recognition.placements.front().registration.information(3, 3) = 0.0;
    return 1.0 / std::sqrt(loop_of(pieces, found, 0.01).information(4, 4));
  };
  EXPECT_GT(lateral_sigma_m(20.0), 10.0 * lateral_sigma_m(0.0));
}

TEST(Bend, leaves_fully_observable_information_unchanged) {
  Mat6 I = Mat6::Zero();
  I.diagonal() << 1e6, 1e6, 1e6, 1e4, 1e4, 1e4;
  const geometry::Mat3 place_m2 = Vec3(9.0, 9.0, 9.0).asDiagonal();
  EXPECT_LT((with_bend(I, place_m2, 0.01, 0.0) - I).norm(), 0.05 * I.norm());
  EXPECT_LT((with_bend(I, geometry::Mat3::Zero(), 0.01, 0.0) - I).norm(), 1e-3 * I.norm())
      << "known without it";
}

// Each comparison in a tunnel finds its axis to a few milliradians. Two of them must not fix the
// position along it like two crossing lines.
TEST(Bend, two_matches_with_slightly_different_degenerate_axes_stay_degenerate_along_both) {
  const double place_m = 3.0;
  const geometry::Mat3 place_m2 = place_m * place_m * geometry::Mat3::Identity();
  const auto along = [](double yaw_rad) {
    return degenerate_along({std::cos(yaw_rad), std::sin(yaw_rad), 0.0}, 0.0);
  };
  const auto sigma_x_m = [](const Mat6& I) {
    Mat6 P = I;
    P.diagonal().array() += 1e-9;
    return std::sqrt(P.inverse()(3, 3));
  };
  EXPECT_LT(sigma_x_m(along(0.003) + along(-0.003)), 3.0) << "as it was";
  EXPECT_GT(sigma_x_m(with_bend(along(0.003), place_m2, 0.01, 0.0) +
                      with_bend(along(-0.003), place_m2, 0.01, 0.0)),
            2.0 * place_m);
}

/// Two paths of one node; a comparison found the second 2 m ahead of the first, to 1 cm.
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
  PathFrames frames_{{{0, 1}}, {0, 0}, {}, {std::nullopt, DecidedBy::kScans}};
};

// 1 cm and no drift: 16 is 4 sigma, 4 cm.
TEST_F(Agrees, with_frames_within_4_sigma_of_the_registration) {
  EXPECT_TRUE(at(placed(2.0, 0.0)));
  EXPECT_TRUE(at(placed(2.03, 0.0)));
  EXPECT_FALSE(at(placed(2.05, 0.0)));
  EXPECT_FALSE(at(placed(2.0, 0.0, 0.1)));
  EXPECT_FALSE(at(placed(-2.0, 0.0)));
}

TEST_F(Agrees, with_any_offset_along_a_degenerate_direction) {
  found_.recognition.certainty = places::Certainty::kAlongAxis;
  found_.recognition.placements.front().registration.information(3, 3) = 0.0;
  EXPECT_TRUE(at(placed(7.0, 0.0)));
  EXPECT_FALSE(at(placed(7.0, 0.1)));
}

TEST_F(Agrees, not_if_ambiguous_or_empty_or_frames_are_not_joined) {
  found_.recognition.certainty = places::Certainty::kAmbiguous;
  EXPECT_FALSE(at(placed(2.0, 0.0)));
  found_.recognition.certainty = places::Certainty::kUnique;
  frames_.group = {0, 1};
  EXPECT_FALSE(at(placed(2.0, 0.0)));
  frames_.group = {0, 0};
  found_.recognition.placements.clear();
  EXPECT_FALSE(at(placed(2.0, 0.0)));
}

TEST_F(Agrees, not_with_a_nan_pose) { EXPECT_FALSE(at(placed(std::nan(""), 0.0))); }

}  // namespace
}  // namespace rali::fleet
