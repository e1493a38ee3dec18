#include "rali/eval/drift.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "rali/eval/alignment.hpp"
#include "rali/eval/consistency.hpp"
#include "rali/eval/statistics.hpp"

namespace rali::eval {
namespace {

using geometry::SE3;
using geometry::Vec3;

SE3 at(double x, double y, double z, double yaw_rad = 0.0) {
  return {geometry::rotation_from_rpy(0.0, 0.0, yaw_rad), Vec3(x, y, z)};
}

/// Along x for ten metres; the estimate has a scale of 1.01 and climbs 0.5 m.
PairList climbing() {
  PairList pairs;
  for (int i = 0; i <= 10; ++i) {
    pairs.push_back({Time::from_s(i), at(3.0 + 1.01 * i, 7.0, 0.05 * i), at(i, 0.0, 0.0),
                     static_cast<std::size_t>(i)});
  }
  return pairs;
}

TEST(Drift, is_the_end_point_distance_after_aligning_the_start_poses) {
  const Drift d = drift(climbing(), SE3{});
  EXPECT_NEAR(d.final_m, std::sqrt(0.01 + 0.25), 1e-12);
  EXPECT_NEAR(d.path_m, 10.0, 1e-12);
  ASSERT_TRUE(d.z_m);
  EXPECT_NEAR(*d.z_m, 0.5, 1e-12);
}

TEST(Drift, has_no_height_error_unless_both_frames_are_level) {
  const SE3 tilted{geometry::rotation_from_rpy(0.5 * std::numbers::pi, 0.0, 0.0), Vec3::Zero()};
  EXPECT_FALSE(drift(climbing(), tilted).z_m);
}

TEST(DegenerateErrors, are_split_along_and_across_the_degenerate_direction) {
  // The map is rotated by 90 degrees: its x axis is the ground truth's y axis.
  const SE3 T_ref_est = at(0.0, 0.0, 0.0, 0.5 * std::numbers::pi);
  PairList pairs;
  pairs.push_back({Time::from_s(0), at(5.3, 0.04, 0.03), at(0.0, 5.0, 0.0), 0});
  pairs.push_back({Time::from_s(1), at(6.0, 0.0, 0.0), at(0.0, 6.0, 0.0), 1});
  const auto errors = degenerate_errors(pairs, T_ref_est, {Vec3(2.0, 0.0, 0.0), Vec3::Zero()});
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0].pair, 0U);
  EXPECT_NEAR(errors[0].along_m, 0.3, 1e-12);
  EXPECT_NEAR(errors[0].across_m, 0.05, 1e-12);
}

TEST(TimeShift, finds_poses_stamped_30_ms_too_early) {
  PairList pairs;
  for (int i = 0; i < 100; ++i) {
    const double t = 0.1 * i;
    const auto place = [](double s) {
      return at(5.0 * std::sin(0.3 * s), 2.0 * std::cos(0.7 * s), 0.0);
    };
    pairs.push_back({Time::from_s(t), place(t + 0.03), place(t), 0});
  }
  const auto shift = time_shift(pairs, SE3{});
  ASSERT_TRUE(shift);
  EXPECT_NEAR(shift->shift_s, 0.03, 1e-4);
  EXPECT_GT(shift->rmse_m, 0.02);
  EXPECT_LT(shift->rmse_after_m, 1e-3);
  EXPECT_FALSE(time_shift({pairs[0], pairs[0], pairs[0]}, SE3{}));
}

TEST(TimeShift, finds_an_offset_absorbed_by_alignment_but_none_on_a_straight_path) {
  PairList bend, straight;
  for (int i = 0; i < 200; ++i) {
    const double t = 0.1 * i;
    // One leg, a corner, another leg; displaced by 3 cm against the truth, as by an alignment.
    const auto place = [](double s) { return at(std::min(s, 10.0), std::max(0.0, s - 10.0), 0.0); };
    SE3 est = place(t + 0.04);
    est.p += Vec3(-0.03, -0.02, 0.0);
    bend.push_back({Time::from_s(t), est, place(t), 0});
    straight.push_back({Time::from_s(t), at(t + 0.04, 0.0, 0.0), at(t, 0.0, 0.0), 0});
  }
  const auto shift = time_shift(bend, SE3{});
  ASSERT_TRUE(shift);
  EXPECT_NEAR(shift->shift_s, 0.04, 0.002);
  EXPECT_LT(shift->rmse_after_m, 0.3 * shift->rmse_m);
  EXPECT_FALSE(time_shift(straight, SE3{}));
}

TEST(ErrorsBetween, are_independent_of_the_frame_but_show_relative_vehicle_errors) {
  const SE3 frame = at(10.0, -3.0, 1.0, 0.8);
  PairList a, b;
  for (int i = 0; i < 5; ++i) {
    const double x = i;
    a.push_back({Time::from_s(0.1 * i), frame * at(x, 0, 0), at(x, 0, 0), 0});
    b.push_back({Time::from_s(0.1 * i + 0.05), frame * at(x + 0.5, 4.6, 0), at(x + 0.5, 4, 0), 0});
  }
  const auto errors = errors_between(a, b, 0.25);
  ASSERT_EQ(errors.size(), 4U);  // the first pose of a is before b's
  for (const PoseError& e : errors) EXPECT_NEAR(e.translation_m, 0.6, 1e-9);
  EXPECT_TRUE(errors_between(a, {}, 0.25).empty());
}

TEST(Nees, bounds_and_gates_agree_with_published_tables) {
  EXPECT_NEAR(nees_bounds(100, 3).low, 2.539, 5e-4);
  EXPECT_NEAR(nees_bounds(100, 3).high, 3.499, 5e-4);
  EXPECT_NEAR(nees_bounds(50, 6).low, 5.078, 5e-4);
  EXPECT_NEAR(nees_bounds(50, 6).high, 6.997, 5e-4);
  EXPECT_NEAR(nees_bounds(200, 1).low, 0.814, 5e-4);
  EXPECT_NEAR(nees_bounds(200, 1).high, 1.205, 5e-4);

  const struct {
    int dof;
    double p99, p999;
  } gates[] = {{1, 6.635, 10.828},
               {2, 9.210, 13.816},
               {3, 11.345, 16.266},
               {4, 13.277, 18.467},
               {6, 16.812, 22.458}};

  for (const auto& gate : gates) {
    EXPECT_NEAR(chi2_quantile(0.99, gate.dof), gate.p99, 5e-4);
    EXPECT_NEAR(chi2_quantile(0.999, gate.dof), gate.p999, 5e-4);
  }
}

}  // namespace
}  // namespace rali::eval
