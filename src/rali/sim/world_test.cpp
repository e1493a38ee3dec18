#include "rali/sim/world.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/sim/clearance.hpp"
#include "rali/sim/motion.hpp"
#include "rali/sim/ray_caster.hpp"

namespace rali::sim {
namespace {

using geometry::SE3;
using geometry::Vec3;

class EveryScene : public testing::TestWithParam<std::size_t> {
 protected:
  [[nodiscard]] Scene scene() const { return static_cast<Scene>(GetParam()); }
};

TEST_P(EveryScene, the_path_crosses_no_surface_and_stays_above_ground) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    const World world = make_world(scene(), seed);
    const RayCaster caster(world.mesh);
    const Trajectory drive = make_trajectory(Route(world.route, world.rounding_m), {}, seed);
    Vec3 before = drive.pose_at(0.0).p;
    for (double t_s = 0.1; t_s < drive.duration_s(); t_s += 0.1) {
      const Vec3 here = drive.pose_at(t_s).p;
      // Horizontal: jolts at the start would point it at the ground.
      const Vec3 step(here.x() - before.x(), here.y() - before.y(), 0.0);
      if (step.norm() > 0.02) {
        // Half a metre of free path ahead is the length of the vehicle itself.
        EXPECT_EQ(caster.cast(before, step.normalized(), 0.5).range_m, 0.0F)
            << "seed " << seed << " at " << here.transpose();
        before = here;
      }
      const Hit ground = caster.cast(here, -Vec3::UnitZ(), 10.0);
      EXPECT_GT(ground.range_m, 0.08F) << "seed " << seed << " at " << here.transpose();
      EXPECT_LT(ground.range_m, 0.45F) << "seed " << seed << " at " << here.transpose();
      for (const double side : {-1.0, 1.0}) {
        const Vec3 left = drive.pose_at(t_s).R.col(1);
        EXPECT_EQ(caster.cast(here, side * left, 0.3).range_m, 0.0F)
            << "seed " << seed << " at " << here.transpose();
      }
    }
  }
}

TEST_P(EveryScene, the_mesh_is_reproducible_and_changes_with_the_seed) {
  const World first = make_world(scene(), 7);
  const World again = make_world(scene(), 7);
  const World other = make_world(scene(), 8);
  EXPECT_EQ(first.mesh.vertices, again.mesh.vertices);
  EXPECT_EQ(first.mesh.triangles.size(), first.mesh.reflectivity.size());
  EXPECT_NE(first.mesh.vertices, other.mesh.vertices);
}

TEST_P(EveryScene, vehicles_of_any_fleet_size_collide_with_nothing) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U}) {
    const World scene_world = make_world(scene(), seed);
    const Clearance clearance(scene_world.mesh);
    for (const int vehicles : {1, 2, 3, 8}) {
      const auto world = world_for(scene_world, vehicles);
      ASSERT_TRUE(world) << world.error().message();
      ASSERT_EQ(world->starts.size(), static_cast<std::size_t>(vehicles));
      std::vector<Vec3> at;
      for (const VehicleStart& start : world->starts) at.push_back(start.p_world_m);
      for (const RoundPlan& round : world->rounds) {
        for (std::size_t i = 0; i < at.size(); ++i) {
          for (std::size_t j = 0; j < i; ++j) EXPECT_GT((at[i] - at[j]).norm(), 0.9);
          if (round.routes[i].empty()) continue;
          EXPECT_LT((round.routes[i].front() - at[i]).norm(), 0.01);
          at[i] = round.routes[i].back();
          const Route route(round.routes[i], world->rounding_m);
          std::vector<Vec3> path;
          for (double s = 0.0; s < route.length_m(); s += 0.2) path.push_back(route.point_at(s));
          const auto contact = clearance.first_contact(path, {});
          EXPECT_FALSE(contact) << "seed " << seed << " at " << contact->transpose();
        }
      }
    }
  }
}

TEST(World, scenes_have_the_fleet_sizes_of_the_paper) {
  EXPECT_EQ(make_world(Scene::kCorridor, 1).starts.size(), 2U);
  EXPECT_EQ(make_world(Scene::kFloor, 1).starts.size(), 3U);
  EXPECT_EQ(make_world(Scene::kLoop, 1).starts.size(), 1U);
  const World loop = make_world(Scene::kLoop, 1);
  ASSERT_EQ(loop.rounds.size(), 1U);
  EXPECT_EQ(loop.rounds[0].routes[0], loop.route);
  EXPECT_FALSE(world_for(loop, 0));
  EXPECT_FALSE(world_for(loop, 11));
}

INSTANTIATE_TEST_SUITE_P(World, EveryScene, testing::Range<std::size_t>(0, kSceneNames.size()),
                         [](const auto& param_info) {
                           return std::string(kSceneNames[param_info.param]);
                         });

TEST(World, path_lengths_match_the_manual) {
  const auto path = [](Scene scene) {
    const World world = make_world(scene, 1);
    return Route(world.route, world.rounding_m).length_m();
  };
  EXPECT_NEAR(path(Scene::kLoop), 165.0, 4.0);
  EXPECT_NEAR(path(Scene::kCorridor), 81.0, 3.0);
  EXPECT_NEAR(path(Scene::kFloor), 89.0, 4.0);
  EXPECT_NEAR(path(Scene::kTunnel), 192.0, 6.0);
}

TEST(World, unknown_scene_names_are_refused_with_the_list_of_scenes) {
  const auto scene = scene_of("lopo");
  ASSERT_FALSE(scene.has_value());
  EXPECT_NE(scene.error().message().find("loop, corridor"), std::string::npos);
  EXPECT_EQ(scene_of("mine").value(), Scene::kMine);
}

TEST(Motion, of_a_cart_bounces_by_centimetres_and_tilts_by_few_degrees) {
  const World world = make_world(Scene::kLoop, 1);
  const Trajectory drive = make_trajectory(Route(world.route, world.rounding_m), {}, 1);
  double z_low = 1.0;
  double z_high = 0.0;
  double tilt = 0.0;
  double speed = 0.0;
  for (double t_s = 0.0; t_s < drive.duration_s(); t_s += 0.02) {
    const MotionState state = drive.at(t_s);
    const Vec3 rpy = geometry::rpy_from_rotation(state.T_world_body.R);
    z_low = std::min(z_low, state.T_world_body.p.z());
    z_high = std::max(z_high, state.T_world_body.p.z());
    tilt = std::max({tilt, std::abs(rpy.x()), std::abs(rpy.y())});
    speed = std::max(speed, state.v_world_mps.norm());
  }
  EXPECT_GT(z_high - z_low, 0.02);
  EXPECT_LT(z_high - z_low, 0.12);
  EXPECT_GT(tilt * 180.0 / M_PI, 1.5);
  EXPECT_LT(tilt * 180.0 / M_PI, 4.0);
  EXPECT_GT(speed, 1.0);
  EXPECT_LT(speed, 2.2);
}

TEST(Motion, standstill_has_no_motion_and_a_start_in_motion_has_speed) {
  const World world = make_world(Scene::kCorridor, 1);
  const Route route(world.route, world.rounding_m);
  MotionOptions o;
  const Trajectory resting = make_trajectory(route, o, 1);
  EXPECT_LT(resting.at(2.0).v_world_mps.norm(), 1e-12);
  EXPECT_LT(resting.at(2.0).a_world_mps2.norm(), 1e-9);
  o.standstill_s = 0.0;
  EXPECT_GT(make_trajectory(route, o, 1).at(0.0).v_world_mps.norm(), 0.5);
}

TEST(Motion, handheld_sensors_and_drones_rotate_about_all_axes) {
  const World world = make_world(Scene::kYard, 1);
  const Route route(world.route, world.rounding_m);
  MotionOptions o;
  for (const Carrier carrier : {Carrier::kHandheld, Carrier::kDrone}) {
    o.carrier = carrier;
    const Trajectory path = make_trajectory(route, o, 1);
    Vec3 maximum = Vec3::Zero();
    for (double t_s = 8.0; t_s < 40.0; t_s += 0.02) {
      maximum = maximum.cwiseMax(path.at(t_s).omega_body_radps.cwiseAbs());
    }
    EXPECT_GT(maximum.minCoeff(), 0.1);
    EXPECT_LT(maximum.maxCoeff(), 3.0);
  }
}

}  // namespace
}  // namespace rali::sim
