#include "rali/ranging/passage_offset.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace rali::ranging {
namespace {

using geometry::Vec3;

TEST(PassageOffset, is_uniformly_distributed_between_two_walls) {
  // 3 m to the left, 2 m to the right, and half a metre of each is the vehicle's: 4 m wide, its
  // middle 0.5 m to the left; sigma of a uniform distribution.
  const FinderSettings settings;
  const LateralOffset lateral = lateral_offset_between_walls(settings, {Vec3::UnitX(), 3.0, 2.0});
  EXPECT_NEAR(lateral.mean_m, 0.5, 1e-12);
  EXPECT_NEAR(lateral.sigma_m, 4.0 / std::sqrt(12.0), 1e-12);
  EXPECT_GT(lateral_offset_between_walls(settings, {Vec3::UnitX(), 0.3, 0.3}).sigma_m, 0.1)
      << "narrower than a vehicle";
}

TEST(PassageOffset, sigma_grows_with_distance_because_of_bends) {
  const FinderSettings settings;
  const LateralOffset near{0.5, 0.3};
  // An arc of 100 m radius is 0.08 m off after 4 m; from 10 m on it is 0.05 per metre.
  EXPECT_NEAR(lateral_offset_in_passage(settings, near, 4.0).sigma_m, 0.3 + 0.08, 1e-12);
  EXPECT_NEAR(lateral_offset_in_passage(settings, near, 20.0).sigma_m, 0.3 + 1.0, 1e-12);
  EXPECT_NEAR(lateral_offset_in_passage(settings, near, 20.0).mean_m, 0.5, 1e-12);
  EXPECT_NEAR(lateral_offset_in_passage(settings, std::nullopt, 20.0).sigma_m, 3.0, 1e-12);
}

TEST(PassageOffset, of_two_vehicles_follows_from_their_wall_distances) {
  // A passage of 5 m: one is 1 m to the right of its middle, the other 0.5 m to the left.
  const FinderSettings settings;
  const PassageWalls own{Vec3::UnitX(), 3.5, 1.5};
  const auto lateral = lateral_offset_by_walls(settings, own, {Vec3::UnitX(), 2.0, 3.0});
  ASSERT_TRUE(lateral);
  EXPECT_NEAR(lateral->mean_m, 1.5, 1e-12);
  EXPECT_NEAR(lateral->sigma_m, 0.1, 1e-12);
  // The other has its axis the other way round: its left is right.
  const auto turned = lateral_offset_by_walls(settings, own, {Vec3(-Vec3::UnitX()), 3.0, 2.0});
  ASSERT_TRUE(turned);
  EXPECT_NEAR(turned->mean_m, 1.5, 1e-12);
}

TEST(PassageOffset, sigma_grows_if_the_passage_is_narrower_for_one_vehicle) {
  // A box of 0.8 m on its left: its middle is 0.4 m farther right than that of the passage.
  const FinderSettings settings;
  const PassageWalls own{Vec3::UnitX(), 2.5, 2.5};
  const auto lateral = lateral_offset_by_walls(settings, own, {Vec3::UnitX(), 1.7, 2.5});
  ASSERT_TRUE(lateral);
  EXPECT_NEAR(lateral->mean_m, 0.4, 1e-12);
  EXPECT_NEAR(lateral->sigma_m, std::hypot(0.1, 0.4), 1e-12) << "it is at 0";
}

TEST(PassageOffset, is_empty_for_vehicles_in_different_passages) {
  const FinderSettings settings;
  EXPECT_FALSE(
      lateral_offset_by_walls(settings, {Vec3::UnitX(), 2.0, 2.0}, {Vec3::UnitY(), 2.0, 2.0}));
}

}  // namespace
}  // namespace rali::ranging
