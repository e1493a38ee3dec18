#include "rali/odometry/paper/octree.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::odometry::paper {
namespace {

using geometry::Vec3f;

struct Cloud {
  std::vector<float> x, y, z;

  void add(const Vec3f& p) {
    x.push_back(p.x());
    y.push_back(p.y());
    z.push_back(p.z());
  }
};

Cloud random_cloud(Rng& rng, int n, double extent) {
  Cloud c;
  for (int k = 0; k < n; ++k) {
    c.add(Vec3f(static_cast<float>(rng.uniform(-extent, extent)),
                static_cast<float>(rng.uniform(-extent, extent)),
                static_cast<float>(rng.uniform(-0.3, 0.3) * extent)));
  }
  return c;
}

Octree tree_of(const Cloud& c) {
  Octree tree;
  tree.build(c.x, c.y, c.z);
  return tree;
}

bool any_by_looking_at_all(const Cloud& c, const Vec3f& q, float radius) {
  for (std::size_t i = 0; i < c.x.size(); ++i) {
    if ((Vec3f(c.x[i], c.y[i], c.z[i]) - q).squaredNorm() < radius * radius) return true;
  }
  return false;
}

TEST(Octree, agrees_with_brute_force_radius_search) {
  Rng rng(1);
  for (const int n : {1, 7, 9, 100, 3000}) {
    const Cloud c = random_cloud(rng, n, 10.0);
    const Octree tree = tree_of(c);
    ASSERT_EQ(tree.size(), c.x.size());
    int found = 0;
    for (int trial = 0; trial < 400; ++trial) {
      const Vec3f q(static_cast<float>(rng.uniform(-13, 13)),
                    static_cast<float>(rng.uniform(-13, 13)),
                    static_cast<float>(rng.uniform(-5, 5)));
      const auto radius = static_cast<float>(rng.uniform(0.0, 4.0));
      const bool expected = any_by_looking_at_all(c, q, radius);
      found += expected ? 1 : 0;
      ASSERT_EQ(tree.any_within(q, radius), expected);
    }
    EXPECT_GT(found, n == 3000 ? 50 : 0);
  }
}

TEST(Octree, excludes_points_exactly_at_the_radius) {
  Cloud c;
  c.add(Vec3f(1.0F, 0.0F, 0.0F));
  const Octree tree = tree_of(c);
  EXPECT_FALSE(tree.any_within(Vec3f::Zero(), 1.0F));
  EXPECT_TRUE(tree.any_within(Vec3f::Zero(), 1.0001F));
  EXPECT_TRUE(tree.any_within(Vec3f(1.0F, 0.0F, 0.0F), 1e-6F));
}

TEST(Octree, of_1000_identical_points_has_few_nodes) {
  Cloud c;
  for (int k = 0; k < 1000; ++k) c.add(Vec3f(1.0F, 2.0F, 3.0F));
  const Octree tree = tree_of(c);
  EXPECT_LT(tree.nodes(), 400U);
  EXPECT_TRUE(tree.any_within(Vec3f(1.0F, 2.0F, 3.0F), 0.01F));
}

TEST(Octree, finds_nothing_without_points_or_with_non_finite_ones) {
  const Octree never_built;
  EXPECT_FALSE(never_built.any_within(Vec3f::Zero(), 1e9F));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  Cloud c;
  c.add(Vec3f(nan, 0.0F, 0.0F));
  c.add(Vec3f(0.0F, inf, 0.0F));
  const Octree rubbish = tree_of(c);
  EXPECT_EQ(rubbish.size(), 0U);
  EXPECT_FALSE(rubbish.any_within(Vec3f::Zero(), 1e9F));
  c.add(Vec3f::Zero());
  const Octree one = tree_of(c);
  EXPECT_FALSE(one.any_within(Vec3f(nan, 0.0F, 0.0F), 1.0F));
  EXPECT_TRUE(one.any_within(Vec3f(0.1F, 0.0F, 0.0F), 1.0F));
}

TEST(Octree, handles_coordinates_of_very_different_magnitude) {
  Cloud c;
  c.add(Vec3f(3e38F, -3e38F, 0.0F));
  for (int k = 0; k < 20; ++k) c.add(Vec3f(0.1F * static_cast<float>(k), 0.0F, 0.0F));
  const Octree tree = tree_of(c);
  EXPECT_TRUE(tree.any_within(Vec3f(0.5F, 0.0F, 0.0F), 0.2F));
}

TEST(Octree, contains_only_the_new_points_after_a_rebuild) {
  Cloud a;
  a.add(Vec3f(1.0F, 0.0F, 0.0F));
  Cloud b;
  b.add(Vec3f(-1.0F, 0.0F, 0.0F));
  Octree tree = tree_of(a);
  tree.build(b.x, b.y, b.z);
  EXPECT_FALSE(tree.any_within(Vec3f(1.0F, 0.0F, 0.0F), 0.5F));
  EXPECT_TRUE(tree.any_within(Vec3f(-1.0F, 0.0F, 0.0F), 0.5F));
}

}  // namespace
}  // namespace rali::odometry::paper
