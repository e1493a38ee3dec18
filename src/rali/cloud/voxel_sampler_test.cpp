#include "rali/cloud/voxel_sampler.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::cloud {
namespace {

struct Cloud {
  std::vector<float> x, y, z;

  void add(double px, double py, double pz) {
    x.push_back(static_cast<float>(px));
    y.push_back(static_cast<float>(py));
    z.push_back(static_cast<float>(pz));
  }

  [[nodiscard]] PointSpan span() const { return {x.data(), y.data(), z.data(), x.size()}; }
};

using Point = std::tuple<float, float, float>;

std::set<Point> kept(const Cloud& cloud, const std::vector<std::uint32_t>& indices) {
  std::set<Point> out;
  for (const std::uint32_t i : indices) out.emplace(cloud.x[i], cloud.y[i], cloud.z[i]);
  return out;
}

Cloud shuffled(const Cloud& cloud, std::uint64_t seed) {
  std::vector<std::size_t> order(cloud.x.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  Rng rng(seed);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[rng.below(i)]);
  Cloud out;
  for (const std::size_t i : order) out.add(cloud.x[i], cloud.y[i], cloud.z[i]);
  return out;
}

Cloud random_cloud(std::size_t n, double size_m) {
  Rng rng(n, "cloud");
  Cloud out;
  for (std::size_t i = 0; i < n; ++i) {
    out.add(rng.uniform(-size_m, size_m), rng.uniform(-size_m, size_m),
            rng.uniform(-size_m, size_m));
  }
  return out;
}

TEST(VoxelSampler, keeps_the_point_nearest_to_the_centre_of_each_cell) {
  Cloud c;
  c.add(0.1, 0.1, 0.1);
  c.add(0.45, 0.5, 0.5);  // nearest to (0.5, 0.5, 0.5)
  c.add(0.9, 0.9, 0.9);
  c.add(-0.1, 0.5, 0.5);  // its own cell: -0.1 rounds down, not to zero
  std::vector<std::uint32_t> out;
  VoxelSampler().sample(c.span(), {}, 1.0, out);
  EXPECT_EQ(out, (std::vector<std::uint32_t>{1, 3}));
}

TEST(VoxelSampler, chooses_the_same_points_in_any_input_order) {
  const Cloud a = random_cloud(3000, 3.0);
  const Cloud b = shuffled(a, 5);
  VoxelSampler sampler;
  for (const bool rays : {false, true}) {
    std::vector<std::uint32_t> from_a;
    std::vector<std::uint32_t> from_b;
    if (rays) {
      sampler.sample_rays(a.span(), {}, 0.5, from_a);
      sampler.sample_rays(b.span(), {}, 0.5, from_b);
    } else {
      sampler.sample(a.span(), {}, 0.5, from_a);
      sampler.sample(b.span(), {}, 0.5, from_b);
    }
    EXPECT_GT(from_a.size(), 100U);
    EXPECT_LT(from_a.size(), 3000U);
    EXPECT_EQ(kept(a, from_a), kept(b, from_b));
    EXPECT_TRUE(std::is_sorted(from_a.begin(), from_a.end()));
  }
}

TEST(VoxelSampler, keeps_exactly_one_point_per_occupied_cell) {
  const Cloud c = random_cloud(2000, 2.0);
  std::vector<std::uint32_t> out;
  VoxelSampler().sample(c.span(), {}, 0.4, out);
  const auto cell = [&c](std::size_t i) {
    return std::tuple(std::floor(c.x[i] * 2.5F), std::floor(c.y[i] * 2.5F),
                      std::floor(c.z[i] * 2.5F));
  };
  std::set<std::tuple<float, float, float>> all;
  std::set<std::tuple<float, float, float>> chosen;
  for (std::size_t i = 0; i < c.x.size(); ++i) all.insert(cell(i));
  for (const std::uint32_t i : out) EXPECT_TRUE(chosen.insert(cell(i)).second);
  EXPECT_EQ(all, chosen);
}

TEST(VoxelSampler, considers_candidates_only_and_appends) {
  const Cloud c = random_cloud(100, 1.0);
  const std::vector<std::uint32_t> candidates{3, 50, 99};
  std::vector<std::uint32_t> out{7};
  VoxelSampler().sample(c.span(), candidates, 1e-3, out);
  EXPECT_EQ(out, (std::vector<std::uint32_t>{7, 3, 50, 99}));
}

TEST(VoxelSampler, result_does_not_depend_on_earlier_calls) {
  VoxelSampler sampler;
  const Cloud small = random_cloud(10, 1.0);
  const Cloud large = random_cloud(5000, 5.0);
  std::vector<std::uint32_t> first;
  sampler.sample(small.span(), {}, 0.5, first);
  std::vector<std::uint32_t> scratch;
  for (int k = 0; k < 3; ++k) {
    scratch.clear();
    sampler.sample(large.span(), {}, 0.5, scratch);
  }
  std::vector<std::uint32_t> again;
  sampler.sample(small.span(), {}, 0.5, again);
  EXPECT_EQ(first, again);
  std::vector<std::uint32_t> none;
  sampler.sample(PointSpan{}, {}, 0.5, none);
  EXPECT_TRUE(none.empty());
}

// A wall 4 m ahead, observed by a grid of rays; only the ranges change. The same rays must be kept.
// Otherwise the sampler would select points by their noise and bias the wall towards the sensor.
// Cells are split at powers of sqrt(2) of the range: none of these ranges is near one.
TEST(VoxelSampler, which_ray_is_kept_does_not_depend_on_its_range_noise) {
  const auto wall = [](double noise_m) {
    Rng rng(9, "noise");
    Cloud c;
    for (int a = -15; a <= 15; ++a) {
      for (int e = -8; e <= 8; ++e) {
        const double x = 1.0;
        const double y = std::tan(0.02 * a);
        const double z = std::tan(0.02 * e);
        const double norm = std::sqrt(x * x + y * y + z * z);
        const double range = 4.6 * norm + noise_m * rng.normal();
        c.add(x / norm * range, y / norm * range, z / norm * range);
      }
    }
    return c;
  };
  std::vector<std::uint32_t> clean;
  std::vector<std::uint32_t> noisy;
  VoxelSampler sampler;
  sampler.sample_rays(wall(0.0).span(), {}, 0.35, clean);
  sampler.sample_rays(wall(0.02).span(), {}, 0.35, noisy);
  std::vector<std::uint32_t> common;
  std::set_intersection(clean.begin(), clean.end(), noisy.begin(), noisy.end(),
                        std::back_inserter(common));
  EXPECT_EQ(clean.size(), noisy.size());
  EXPECT_GT(static_cast<double>(common.size()), 0.97 * static_cast<double>(clean.size()));
}

// Verifies the above: the kept ranges have the mean of all ranges; with cubes they do not.
TEST(VoxelSampler, kept_rays_have_no_bias_in_range) {
  double sum_m = 0.0;
  int n = 0;
  VoxelSampler sampler;
  Rng rng(10, "bias");
  for (int k = 0; k < 40; ++k) {
    Cloud c;
    const double distance_m = 4.6 + 0.02 * k;
    std::vector<double> noise;
    for (int i = 0; i < 400; ++i) {
      const double y = 0.002 * (i - 200);
      const double norm = std::hypot(1.0, y);
      noise.push_back(0.02 * rng.normal());
      const double range = distance_m * norm + noise.back();
      c.add(range / norm, range * y / norm, 0.01);
    }
    std::vector<std::uint32_t> out;
    sampler.sample_rays(c.span(), {}, 0.05, out);
    for (const std::uint32_t i : out) {
      sum_m += noise[i];
      ++n;
    }
  }
  ASSERT_GT(n, 1000);
  EXPECT_LT(std::abs(sum_m / n), 3.0 * 0.02 / std::sqrt(n));
}

TEST(VoxelSampler, accepts_points_at_the_grid_border_and_at_the_origin) {
  Cloud c;
  c.add(1e5, -1e5, 1e5);
  c.add(-1e5, 1e5, 0.0);
  c.add(0.0, 0.0, 0.0);
  c.add(1e-30, 0.0, 0.0);
  std::vector<std::uint32_t> out;
  VoxelSampler().sample(c.span(), {}, 0.1, out);
  EXPECT_EQ(out.size(), 3U);
  out.clear();
  VoxelSampler().sample_rays(c.span(), {}, 0.1, out);
  EXPECT_GE(out.size(), 3U);
}

TEST(VoxelKey, clamps_cells_outside_the_grid_and_separates_all_inside) {
  constexpr int kHalf = 1 << 20;
  EXPECT_EQ(voxel_key(kHalf + 5, 0, 0), voxel_key(kHalf - 1, 0, 0));
  EXPECT_EQ(voxel_key(-kHalf - 5, 0, 0), voxel_key(-kHalf, 0, 0));
  std::set<std::uint64_t> keys;
  for (int x = -2; x <= 2; ++x) {
    for (int y = -2; y <= 2; ++y) {
      for (int z = -2; z <= 2; ++z) keys.insert(voxel_key(x, y, z));
    }
  }
  EXPECT_EQ(keys.size(), 125U);
}

TEST(FloorToInt, rounds_down_on_both_sides_of_zero) {
  EXPECT_EQ(floor_to_int(1.9), 1);
  EXPECT_EQ(floor_to_int(-0.1), -1);
  EXPECT_EQ(floor_to_int(-2.0F), -2);
  EXPECT_EQ(floor_to_int(0.0F), 0);
  EXPECT_EQ(floor_to_int(-1e9), -1000000000);
}

}  // namespace
}  // namespace rali::cloud
