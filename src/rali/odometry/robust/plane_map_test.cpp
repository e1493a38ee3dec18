#include "rali/odometry/robust/plane_map.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/odometry/robust/patches_for_test.hpp"

namespace rali::odometry {
namespace {

using geometry::Vec3;

TEST(PlaneMap, fits_one_plane_to_one_wall) {
  PlaneMap map{PlaneMapSettings{}};
  EXPECT_TRUE(map.empty());
  insert_patch(map, {Vec3(0.4, 0.4, 0.3), Vec3::UnitZ()});
  EXPECT_EQ(map.root_count(), 1U);
  EXPECT_EQ(map.plane_count(), 1U);
  const int index = map.find(Vec3(0.1, 0.7, 0.5));
  ASSERT_GE(index, 0);
  EXPECT_NEAR(std::abs(map.plane(index).n.z()), 1.0, 1e-12);
  EXPECT_NEAR(map.plane(index).q.z(), 0.3, 1e-12);
}

TEST(PlaneMap, finds_nothing_where_nothing_was_inserted) {
  PlaneMap map{PlaneMapSettings{}};
  EXPECT_EQ(map.find(Vec3(0.4, 0.4, 0.4)), -1);
  EXPECT_EQ(map.find_near(Vec3(0.4, 0.4, 0.4)), -1);
  insert_patch(map, {Vec3(0.4, 0.4, 0.3), Vec3::UnitZ()});
  EXPECT_EQ(map.find(Vec3(-0.4, 0.4, 0.3)), -1);
  EXPECT_EQ(map.find(Vec3(1e5, -1e5, 1e5)), -1);
}

TEST(PlaneMap, splits_a_cell_that_contains_floor_and_wall) {
  PlaneMap map{PlaneMapSettings{}};
  Rng rng(1, "corner");
  for (int k = 0; k < 1500; ++k) {
    const double a = rng.uniform(0.0, 0.8);
    const double b = rng.uniform(0.0, 0.8);
    if (k % 2 == 0) {
      map.insert(Vec3(a, b, 0.1), Vec3::UnitZ().cast<float>(), 0.0);
    } else {
      map.insert(Vec3(a, 0.7, b), Vec3::UnitY().cast<float>(), 0.0);
    }
  }
  EXPECT_EQ(map.root_count(), 1U);
  const int floor = map.find(Vec3(0.2, 0.2, 0.1));
  const int wall = map.find(Vec3(0.2, 0.7, 0.6));
  ASSERT_GE(floor, 0);
  ASSERT_GE(wall, 0);
  EXPECT_NE(floor, wall);
  EXPECT_NEAR(std::abs(map.plane(floor).n.z()), 1.0, 1e-6);
  EXPECT_NEAR(std::abs(map.plane(wall).n.y()), 1.0, 1e-6);
}

/// Number of planes from four spots that are measured by ten scans.
std::size_t planes_of_four_spots(double step_m) {
  const Vec3 spots[] = {{0.3, 0.3, 0.5}, {0.5, 0.3, 0.5}, {0.3, 0.5, 0.5}, {0.5, 0.5, 0.5}};
  PlaneMap map{PlaneMapSettings{}};
  Rng rng(3, "spots");
  for (int scan = 0; scan < 10; ++scan) {
    const geometry::SE3 T_odom_lidar{geometry::Mat3::Identity(), {step_m * scan, 0.0, 3.0}};
    map.set_view(T_odom_lidar);
    for (const Vec3& spot : spots) {
      const Vec3 ray = (spot - T_odom_lidar.p).normalized();
      map.insert(spot + 0.01 * rng.normal() * ray, ray.cast<float>(), 0.0);
    }
  }
  return map.plane_count();
}

TEST(PlaneMap, fits_no_plane_to_four_spots_seen_from_one_position) {
  EXPECT_EQ(planes_of_four_spots(0.0), 0U);
  EXPECT_EQ(planes_of_four_spots(0.002), 0U) << "all within 2 cm";
  EXPECT_EQ(planes_of_four_spots(0.1), 1U);
}

TEST(PlaneMap, fits_few_planes_to_scattered_points) {
  PlaneMap map{PlaneMapSettings{}};
  Rng rng(2, "bush");
  for (int k = 0; k < 4000; ++k) {
    const Vec3 p(rng.uniform(0.0, 0.8), rng.uniform(0.0, 0.8), rng.uniform(0.0, 0.8));
    map.insert(p, p.normalized().cast<float>(), 0.0);
  }
  int found = 0;
  for (int k = 0; k < 200; ++k) {
    found +=
        map.find(Vec3(rng.uniform(0.0, 0.8), rng.uniform(0.0, 0.8), rng.uniform(0.0, 0.8))) >= 0;
  }
  EXPECT_LT(found, 50);  // by chance, in the finest cells, which may be rough
}

// The most frequent false plane of sensors with few rings: one ring on the floor at a grazing
// angle, widened by range noise.
TEST(PlaneMap, planes_fitted_to_one_floor_ring_are_within_4_sigma) {
  Rng rng(3, "ring");
  int planes = 0;
  int wrong = 0;
  for (int trial = 0; trial < 40; ++trial) {
    PlaneMap map{PlaneMapSettings{}};
    for (int scan = 0; scan < 8; ++scan) {
      for (int i = 0; i < 90; ++i) {
        const double a = 0.0023 * i + 0.0003 * rng.normal();
        const Vec3 p(8.0 * std::cos(a), 8.0 * std::sin(a), -0.9);
        const Vec3 ray = p.normalized();
        map.insert(p + 0.02 * rng.normal() * ray, ray.cast<float>(), 0.0);
      }
    }
    for (std::size_t k = 0; k < map.plane_count(); ++k) {
      const Plane& plane = map.plane(static_cast<int>(k));
      const double t1 = std::pow(plane.e1.z(), 2) / plane.var_tilt1;
      const double t2 = std::pow(plane.e2.z(), 2) / plane.var_tilt2;
      ++planes;
      wrong += t1 + t2 > 16.0;  // more than 4 sigma
    }
  }
  EXPECT_EQ(wrong, 0) << "of " << planes;
}

TEST(PlaneMap, freezes_a_plane_that_has_enough_points) {
  PlaneMapSettings settings;
  settings.freeze_points = 100;
  PlaneMap map{settings};
  Patch patch{Vec3(0.4, 0.4, 0.3), Vec3::UnitZ()};
  for (int k = 0; k < 3; ++k) insert_patch(map, patch);
  const int index = map.find(patch.center);
  ASSERT_GE(index, 0);
  const Plane before = map.plane(index);
  patch.center.z() = 0.31;
  for (int k = 0; k < 10; ++k) insert_patch(map, patch);
  EXPECT_EQ(map.plane(index).q, before.q);
  EXPECT_EQ(map.plane(index).var_offset, before.var_offset);
}

TEST(PlaneMap, an_unfrozen_plane_is_updated_by_new_points) {
  PlaneMap map{PlaneMapSettings{}};
  Patch patch{Vec3(0.4, 0.4, 0.300), Vec3::UnitZ()};
  insert_patch(map, patch);
  const double var = map.plane(map.find(patch.center)).var_offset;
  patch.center.z() = 0.302;
  patch.epoch = 4.0;
  insert_patch(map, patch);
  insert_patch(map, patch);
  const Plane& plane = map.plane(map.find(patch.center));
  EXPECT_GT(plane.q.z(), 0.3005);
  EXPECT_GT(plane.epoch, 1.0);  // mean generation of its points
  EXPECT_LT(plane.epoch, 4.0);
  EXPECT_LT(plane.var_offset, var);
}

TEST(PlaneMap, find_near_searches_across_the_cell_border) {
  PlaneMap map{PlaneMapSettings{}};
  insert_patch(map, {Vec3(0.4, 0.4, 0.75), Vec3::UnitZ()});
  const Vec3 beyond(0.4, 0.4, 0.85);  // in the next cell above
  EXPECT_EQ(map.find(beyond), -1);
  EXPECT_EQ(map.find_near(beyond), map.find(Vec3(0.4, 0.4, 0.7)));
  // Of two planes it takes the nearer one.
  insert_patch(map, {Vec3(0.4, 0.4, 1.5), Vec3::UnitZ()});
  EXPECT_EQ(map.find(beyond), map.find(Vec3(0.4, 0.4, 1.5)));
  EXPECT_EQ(map.find_near(beyond), map.find(Vec3(0.4, 0.4, 0.7)));
}

TEST(PlaneMap, prunes_distant_cells_above_the_limit_and_keeps_near_ones) {
  PlaneMapSettings settings;
  settings.roots_max = 40;
  settings.keep_radius_m = 10.0;
  PlaneMap map{settings};
  for (int k = 0; k < 60; ++k) insert_patch(map, {Vec3(0.8 * k + 0.4, 0.4, 0.3), Vec3::UnitZ()});
  ASSERT_EQ(map.root_count(), 60U);
  const Plane near_one = map.plane(map.find(Vec3(2.8, 0.4, 0.3)));
  const std::size_t forgotten = map.prune(Vec3::Zero());
  EXPECT_EQ(forgotten + map.root_count(), 60U);
  EXPECT_GT(forgotten, 40U);
  EXPECT_EQ(map.find(Vec3(40.4, 0.4, 0.3)), -1);
  const int index = map.find(Vec3(2.8, 0.4, 0.3));
  ASSERT_GE(index, 0);
  EXPECT_EQ(map.plane(index).q, near_one.q);
  EXPECT_EQ(map.plane_count(), map.root_count());
  EXPECT_EQ(map.prune(Vec3::Zero()), 0U);  // few enough now
  // Insertion still works.
  insert_patch(map, {Vec3(40.4, 0.4, 0.3), Vec3::UnitZ()});
  EXPECT_GE(map.find(Vec3(40.4, 0.4, 0.3)), 0);
}

TEST(PlaneMap, does_not_prune_again_after_every_new_cell) {
  PlaneMapSettings settings;
  settings.roots_max = 40;
  settings.keep_radius_m = 30.0;
  PlaneMap map{settings};
  const auto add = [&map](int first, int last, double x_m) {
    for (int k = first; k < last; ++k) {
      insert_patch(map, {Vec3(x_m + 0.8 * k + 0.4, 0.4, 0.3), Vec3::UnitZ()});
    }
  };
  add(0, 36, 0.0);
  add(0, 10, 400.0);
  EXPECT_EQ(map.prune(Vec3::Zero()), 10U);
  add(0, 5, 400.0);
  EXPECT_EQ(map.prune(Vec3::Zero()), 0U);  // 41, but 36 + 40 / 8 are allowed now
  add(5, 6, 400.0);
  EXPECT_EQ(map.prune(Vec3::Zero()), 6U);
}

TEST(PlaneMap, keeps_split_cells_when_pruning) {
  PlaneMapSettings settings;
  settings.roots_max = 1;
  PlaneMap map{settings};
  Rng rng(4, "split");
  for (int k = 0; k < 1500; ++k) {
    const double a = rng.uniform(0.0, 0.8);
    const double b = rng.uniform(0.0, 0.8);
    const Vec3 p = k % 2 == 0 ? Vec3(a, b, 0.1) : Vec3(a, 0.7, b);
    map.insert(p, (k % 2 == 0 ? Vec3::UnitZ() : Vec3::UnitY()).cast<float>(), 0.0);
  }
  insert_patch(map, {Vec3(500.0, 0.4, 0.3), Vec3::UnitZ()});
  const Plane before = map.plane(map.find(Vec3(0.2, 0.7, 0.6)));
  EXPECT_GT(map.prune(Vec3::Zero()), 0U);
  const int index = map.find(Vec3(0.2, 0.7, 0.6));
  ASSERT_GE(index, 0);
  EXPECT_EQ(map.plane(index).q, before.q);
}

TEST(PlaneMap, grows_over_thousands_of_cells_and_hashes_its_content) {
  const auto build = [](double z_m) {
    PlaneMap map{PlaneMapSettings{}};
    for (int i = 0; i < 4000; ++i) {
      map.insert(Vec3(0.8 * (i % 80) - 30.0, 0.8 * (i / 80) - 20.0, z_m),
                 Vec3::UnitZ().cast<float>(), 0.0);
    }
    insert_patch(map, {Vec3(100.4, 0.4, z_m), Vec3::UnitZ()});
    return map;
  };
  const PlaneMap a = build(0.3);
  EXPECT_GE(a.root_count(), 3900U);
  EXPECT_EQ(a.hash(), build(0.3).hash());
  EXPECT_NE(a.hash(), build(0.3 + 1e-12).hash());
}

}  // namespace
}  // namespace rali::odometry
