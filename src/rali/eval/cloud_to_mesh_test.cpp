#include "rali/eval/cloud_to_mesh.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::eval {
namespace {

using geometry::SE3;
using geometry::Vec3;

/// The unit plate at z = 0.
TriangleMesh plate() {
  return {{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0)}, {{0, 1, 2}, {0, 2, 3}}};
}

/// Closed room of length x width x height with its corner at the origin.
TriangleMesh room(double l, double w, double h) {
  TriangleMesh m;
  for (int i = 0; i < 8; ++i) {
    m.vertices.emplace_back((i & 1) != 0 ? l : 0.0, (i & 2) != 0 ? w : 0.0, (i & 4) != 0 ? h : 0.0);
  }
  m.triangles = {{0, 1, 3}, {0, 3, 2}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                 {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 3, 7}, {1, 7, 5}};
  return m;
}

TriangleMesh random_soup(std::size_t n, Rng& rng) {
  TriangleMesh m;
  for (std::uint32_t t = 0; t < n; ++t) {
    const Vec3 at(rng.uniform(-10, 10), rng.uniform(-10, 10), rng.uniform(-2, 2));
    // Small and large triangles, slivers and points.
    const double size_m = t % 7 == 0 ? 5.0 : (t % 11 == 0 ? 0.0 : 0.3);
    for (int k = 0; k < 3; ++k) {
      m.vertices.push_back(at + size_m * Vec3(rng.uniform(-1, 1), rng.uniform(-1, 1),
                                              t % 5 == 0 ? 0.0 : rng.uniform(-1, 1)));
    }
    m.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  return m;
}

/// Runs blocks from the last to the first, as threads may finish them.
class BackwardsExecutor final : public Executor {
 public:
  void for_blocks(std::size_t n, std::size_t block,
                  const std::function<void(std::size_t, std::size_t, std::size_t)>& f) override {
    for (std::size_t k = (n + block - 1) / block; k-- > 0;) {
      f(k, k * block, std::min(n, (k + 1) * block));
    }
  }
};

TEST(CloudToMesh, five_points_over_a_plate_match_hand_computed_statistics) {
  const PointList points{Vec3(.5, .5, .1), Vec3(.5, .5, -.2), Vec3(1.3, .5, .4), Vec3(2, 2, 0),
                         Vec3(0, 0, 0)};
  const TriangleMesh mesh = plate();
  const TriangleTree tree(mesh);
  SerialExecutor serial;
  const std::vector<double> d = distances_to_mesh(points, tree, serial);
  EXPECT_NEAR(d[0], 0.1, 1e-15);
  EXPECT_NEAR(d[1], 0.2, 1e-15);
  EXPECT_NEAR(d[2], 0.5, 1e-15);
  EXPECT_NEAR(d[3], std::sqrt(2.0), 1e-15);
  EXPECT_EQ(d[4], 0.0);
  const CloudToMesh c = cloud_to_mesh(points, SE3{}, mesh, tree, {}, serial);
  EXPECT_NEAR(c.all.mean, 0.4428, 5e-5);
  EXPECT_NEAR(c.all.std, 0.5137, 5e-5);
  EXPECT_NEAR(c.within.mean, 0.2000, 1e-12);
  EXPECT_NEAR(c.within.std, 0.1871, 5e-5);
  EXPECT_NEAR(c.fraction_beyond, 0.20, 1e-12);
  EXPECT_EQ(c.beyond, 1U);
}

TEST(CloudToMesh, tree_agrees_with_brute_force_over_all_triangles) {
  Rng rng(7, "soup");
  const TriangleMesh mesh = random_soup(400, rng);
  const TriangleTree tree(mesh);
  for (int i = 0; i < 500; ++i) {
    const Vec3 p(rng.uniform(-15, 15), rng.uniform(-15, 15), rng.uniform(-5, 5));
    double minimum = std::numeric_limits<double>::infinity();
    for (const auto& [a, b, c] : mesh.triangles) {
      const Vec3 q = closest_on_triangle(p, mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]);
      minimum = std::min(minimum, (q - p).norm());
    }
    const TriangleTree::Nearest found = tree.nearest(p);
    EXPECT_DOUBLE_EQ(found.distance_m, minimum);
    EXPECT_NEAR((found.point - p).norm(), minimum, 1e-12);
  }
}

TEST(CloudToMesh, tree_is_exact_far_from_the_origin_too) {
  Rng rng(9, "far");
  TriangleMesh mesh = random_soup(300, rng);
  const Vec3 utm_m(4.5e5, 5.4e6, 300.0);  // float has a resolution of 0.5 m there
  for (Vec3& v : mesh.vertices) v += utm_m;
  const TriangleTree tree(mesh);
  for (int i = 0; i < 300; ++i) {
    // From positions near the mesh, and from a hundred times its size away.
    const double reach_m = i % 2 == 0 ? 15.0 : 1500.0;
    const Vec3 p = utm_m + reach_m * Vec3(rng.uniform(-1, 1), rng.uniform(-1, 1), 0.1);
    double minimum = std::numeric_limits<double>::infinity();
    for (const auto& [a, b, c] : mesh.triangles) {
      const Vec3 q = closest_on_triangle(p, mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]);
      minimum = std::min(minimum, (q - p).norm());
    }
    EXPECT_DOUBLE_EQ(tree.nearest(p).distance_m, minimum);
  }
}

TEST(CloudToMesh, nearest_of_equidistant_triangles_is_the_first) {
  TriangleMesh mesh = plate();
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 2, 3}, {0, 1, 2}};
  const TriangleTree tree(mesh);
  EXPECT_EQ(tree.nearest(Vec3(0.5, 0.5, 0.1)).triangle, 0U) << "on the diagonal";
  EXPECT_EQ(tree.nearest(Vec3(0.2, 0.6, 0.1)).triangle, 1U);
}

TEST(CloudToMesh, closest_point_is_no_farther_than_any_sampled_triangle_point) {
  Rng rng(3, "net");
  for (int i = 0; i < 40; ++i) {
    const auto any = [&] {
      return Vec3(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
    };
    const Vec3 a = any(), b = any(), c = i % 4 == 0 ? Vec3(a + 2.0 * (b - a)) : any(),
               p = 2.0 * any();
    const double d = (closest_on_triangle(p, a, b, c) - p).norm();
    double net = std::numeric_limits<double>::infinity();
    for (int u = 0; u <= 60; ++u) {
      for (int v = 0; u + v <= 60; ++v) {
        net = std::min(net, (a + u / 60.0 * (b - a) + v / 60.0 * (c - a) - p).norm());
      }
    }
    EXPECT_LE(d, net + 1e-12);
    EXPECT_GE(d, net - 0.1);
  }
}

TEST(CloudToMesh, tree_handles_a_thousand_identical_triangles) {
  TriangleMesh mesh = plate();
  mesh.triangles.assign(1000, {0, 1, 2});
  const TriangleTree tree(mesh);
  EXPECT_NEAR(tree.nearest(Vec3(0.6, 0.2, 3.0)).distance_m, 3.0, 1e-15);
}

TEST(CloudToMesh, result_does_not_depend_on_the_block_execution_order) {
  Rng rng(5, "order");
  const TriangleMesh mesh = random_soup(200, rng);
  const TriangleTree tree(mesh);
  PointList points;
  for (int i = 0; i < 5000; ++i) points.emplace_back(rng.uniform(-9, 9), rng.uniform(-9, 9), 0.0);
  SerialExecutor serial;
  BackwardsExecutor backwards;
  const CloudToMesh a = cloud_to_mesh(points, SE3{}, mesh, tree, {}, serial);
  const CloudToMesh b = cloud_to_mesh(points, SE3{}, mesh, tree, {}, backwards);
  EXPECT_EQ(a.all.mean, b.all.mean);
  EXPECT_EQ(a.within.std, b.within.std);
  EXPECT_EQ(a.completeness, b.completeness);
}

TEST(CloudToMesh, completeness_of_a_half_mapped_plate_is_0_5) {
  TriangleMesh mesh = plate();
  for (Vec3& v : mesh.vertices) v *= 10.0;
  PointList points;
  for (double x = 0.025; x < 4.9; x += 0.05) {
    for (double y = 0.025; y < 10.0; y += 0.05) points.emplace_back(x, y, 0.0);
  }
  const TriangleTree tree(mesh);
  SerialExecutor serial;
  const CloudToMesh c = cloud_to_mesh(points, SE3{}, mesh, tree, {}, serial);
  EXPECT_EQ(c.samples, 10000U);
  EXPECT_NEAR(c.completeness, 0.5, 0.01);
  EXPECT_NEAR(c.all.max, 0.0, 1e-12);
}

TEST(CloudToMesh, counts_and_ignores_non_finite_points) {
  const double nan = std::nan("");
  const PointList points{Vec3(nan, 0, 0), Vec3(0.5, 0.5, 0.3), Vec3(0, 1.0 / 0.0, 0)};
  const TriangleMesh mesh = plate();
  const TriangleTree tree(mesh);
  SerialExecutor serial;
  const CloudToMesh c = cloud_to_mesh(points, SE3{}, mesh, tree, {}, serial);
  EXPECT_EQ(c.not_finite, 2U);
  EXPECT_EQ(c.all.count, 1U);
  EXPECT_NEAR(c.all.mean, 0.3, 1e-12);
  EXPECT_EQ(cloud_to_mesh({}, SE3{}, mesh, tree, {}, serial).all.count, 0U);
}

TEST(Mesh, refuses_invalid_meshes_and_names_the_defect) {
  TriangleMesh mesh = plate();
  EXPECT_TRUE(check_mesh(mesh, "m.ply"));
  mesh.triangles.push_back({0, 1, 4000000000U});
  EXPECT_NE(check_mesh(mesh, "m.ply").error().message().find("vertex 4000000000"),
            std::string::npos);
  EXPECT_FALSE(check_mesh({}, "m.ply"));
  mesh = plate();
  mesh.vertices[2].y() = std::nan("");
  EXPECT_FALSE(check_mesh(mesh, "m.ply"));
  mesh.vertices[2].y() = 1e20;
  EXPECT_NE(check_mesh(mesh, "m.ply").error().message().find("metres"), std::string::npos);
}

TEST(Mesh, samples_are_distributed_in_proportion_to_area) {
  TriangleMesh mesh = plate();
  mesh.vertices.insert(mesh.vertices.end(), {Vec3(5, 0, 0), Vec3(8, 0, 0), Vec3(5, 2, 0)});
  mesh.triangles.push_back({4, 5, 6});  // 3 square metres beside 1
  const auto samples = sample_surface(mesh, 0.1, 1000000);
  ASSERT_EQ(samples.size(), 400U);
  const auto far =
      std::count_if(samples.begin(), samples.end(), [](const Vec3& p) { return p.x() >= 5.0; });
  EXPECT_NEAR(static_cast<double>(far), 300.0, 1.0);
  EXPECT_EQ(sample_surface(mesh, 0.001, 500).size(), 500U);
}

TEST(MeshIcp, aligns_a_shifted_and_rotated_room) {
  const TriangleMesh mesh = room(6.0, 4.0, 2.5);
  const TriangleTree tree(mesh);
  const PointList points = sample_surface(mesh, 0.1, 100000);
  const SE3 off{geometry::rotation_from_rpy(0.01, -0.02, 0.03), Vec3(0.1, -0.08, 0.05)};
  SerialExecutor serial;
  const auto icp = align_to_mesh(points, off, tree, {}, serial);
  ASSERT_TRUE(icp);
  EXPECT_TRUE(icp->converged);
  EXPECT_EQ(icp->open_directions, 0);
  EXPECT_LT(icp->rmse_m, 1e-5);
  EXPECT_GT(icp->rmse_start_m, 0.02);
  EXPECT_LT(icp->T_mesh_cloud.p.norm(), 1e-4);
  EXPECT_LT(geometry::so3_log(icp->T_mesh_cloud.R).norm(), 1e-4);
}

TEST(MeshIcp, is_robust_to_8_percent_outliers) {
  const TriangleMesh mesh = room(6.0, 4.0, 2.5);
  const TriangleTree tree(mesh);
  PointList points = sample_surface(mesh, 0.1, 100000);
  for (std::size_t i = 0; i < points.size(); i += 12) points[i].z() += 0.9;
  SerialExecutor serial;
  const auto icp =
      align_to_mesh(points, {geometry::Mat3::Identity(), Vec3(0.05, 0.05, 0.0)}, tree, {}, serial);
  ASSERT_TRUE(icp);
  EXPECT_LT(icp->T_mesh_cloud.p.norm(), 5e-3);
}

TEST(MeshIcp, keeps_the_start_pose_along_unobservable_directions_of_a_plate) {
  TriangleMesh mesh = plate();
  for (Vec3& v : mesh.vertices) v = 100.0 * (v - Vec3(0.5, 0.5, 0.0));
  const TriangleTree tree(mesh);
  PointList points;
  for (int i = 0; i < 400; ++i) points.emplace_back(0.1 * (i % 20), 0.1 * (i / 20), 0.0);
  const SE3 off{geometry::Mat3::Identity(), Vec3(0.3, -0.2, 0.1)};
  SerialExecutor serial;
  const auto icp = align_to_mesh(points, off, tree, {}, serial);
  ASSERT_TRUE(icp);
  EXPECT_EQ(icp->open_directions, 3);
  EXPECT_NEAR(icp->T_mesh_cloud.p.x(), 0.3, 1e-9);
  EXPECT_NEAR(icp->T_mesh_cloud.p.y(), -0.2, 1e-9);
  EXPECT_NEAR(icp->T_mesh_cloud.p.z(), 0.0, 1e-6);
  EXPECT_FALSE(align_to_mesh({Vec3(0, 0, 0)}, off, tree, {}, serial));
}

}  // namespace
}  // namespace rali::eval
