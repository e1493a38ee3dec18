#include "rali/places/correlator.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::places {
namespace {

using geometry::Vec2;

constexpr double kCell_m = 0.4;

/// An L of two walls with clutter: marks at cell centres, as marks_of() gives them. All weights
/// differ: among equal neighbours rounding would decide which one is the peak.
std::vector<Mark> marks(std::uint64_t seed) {
  Rng rng(seed, "marks");
  std::vector<Mark> out;
  const auto add = [&](int x, int y) {
    out.push_back({static_cast<float>((x + 0.5) * kCell_m), static_cast<float>((y + 0.5) * kCell_m),
                   static_cast<float>(rng.uniform(0.5, 1.0))});
  };
  for (int k = -20; k < 20; ++k) add(k, 8);
  for (int k = -6; k < 8; ++k) add(20, k);
  for (int k = 0; k < 30; ++k) {
    add(static_cast<int>(rng.below(30)) - 15, static_cast<int>(rng.below(20)) - 10);
  }
  return out;
}

bool inside(const ShiftWindow& w, const Vec2& p) {
  return (p.array() > w.low_m.array()).all() && (p.array() < w.high_m.array()).all();
}

std::vector<Place> everywhere(const Picture& picture, std::span<const Mark> of, double yaw_rad) {
  std::vector<Place> found;
  Correlator(picture, of, kCell_m).correlate(yaw_rad, yaw_rad, found);
  found.resize(found.size() / 2);  // the second yaw is the first one again
  return found;
}

TEST(CorrelateWithin, finds_the_same_peaks_as_the_fft_correlator) {
  int compared = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const std::vector<Mark> source = marks(seed);
    const Picture picture(source, kCell_m);
    for (const double yaw_rad : {0.0, 0.05, -0.1}) {
      const ShiftWindow window{Vec2(-2.3, -1.7), Vec2(2.1, 2.5)};
      std::vector<Place> near;
      correlate_within(picture, source, kCell_m, yaw_rad, window, near);
      for (const Place& p : everywhere(picture, source, yaw_rad)) {
        if (!inside(window, p.shift_m)) continue;
        ++compared;
        EXPECT_TRUE(std::any_of(near.begin(), near.end(),
                                [&](const Place& q) {
                                  return (p.shift_m - q.shift_m).norm() < 1e-6 &&
                                         std::abs(p.correlation - q.correlation) < 1e-4;
                                }))
            << "seed " << seed << ", yaw " << yaw_rad << " at " << p.shift_m.transpose();
      }
    }
  }
  EXPECT_GE(compared, 15) << "one for each seed and yaw, at least";
}

TEST(CorrelateWithin, self_correlation_peaks_within_one_cell_of_zero_shift) {
  const std::vector<Mark> source = marks(3);
  std::vector<Place> near;
  correlate_within(Picture(source, kCell_m), source, kCell_m, 0.0, {Vec2(-3, -3), Vec2(3, 3)},
                   near);
  ASSERT_FALSE(near.empty());
  // Shifts are whole cells, and marks are rounded to one: half a cell is the smallest error.
  EXPECT_LT(near.front().shift_m.norm(), kCell_m);
  EXPECT_GT(near.front().correlation, 0.6);
}

TEST(CorrelateWithin, finds_nothing_when_the_window_is_outside_the_image) {
  const std::vector<Mark> source = marks(1);
  std::vector<Place> near;
  correlate_within(Picture(source, kCell_m), source, kCell_m, 0.0, {Vec2(100, 100), Vec2(103, 103)},
                   near);
  EXPECT_TRUE(near.empty());
}

}  // namespace
}  // namespace rali::places
