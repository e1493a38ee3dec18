#include "rali/odometry/robust/turn_speed.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace rali::odometry {
namespace {

using geometry::Mat3;
using geometry::Vec3;

constexpr double kSpan_s = 0.1;
const Vec3 kUp = Vec3::UnitZ();

TurnSpeed known(double sigma_radps = 0.0) {
  TurnSpeed out;
  out.know(Vec3::Zero(), sigma_radps * sigma_radps * Mat3::Identity());
  return out;
}

/// Drives at `true_mps` along a bend; `estimated_mps` is the speed of the estimate, which steers
/// alike.
TurnSpeed::Step step(double bend_radpm, double true_mps, double estimated_mps, double steer_radps) {
  TurnSpeed::Step s;
  s.span_s = kSpan_s;
  s.bend_radpm = bend_radpm;
  s.gyro_rad = (bend_radpm * true_mps + steer_radps) * kSpan_s;
  s.turn_rad = (bend_radpm * estimated_mps + steer_radps) * kSpan_s;
  s.way_m = estimated_mps * kSpan_s;
  return s;
}

TurnSpeed::Measurement next(TurnSpeed& turn, const TurnSpeed::Step& s) {
  for (int k = 0; k < 1000; ++k) {
    if (const auto measured = turn.add(s, kUp)) return *measured;
  }
  ADD_FAILURE() << "no measurement";
  return {};
}

TEST(TurnSpeed, measures_the_error_of_the_speed_in_a_bend_also_while_steering) {
  for (const double bend_radpm : {0.01, -0.004}) {
    for (const double steer_radps : {0.0, 0.2}) {
      TurnSpeed turn = known();
      const auto measured = next(turn, step(bend_radpm, 1.0, 1.25, steer_radps));
      EXPECT_NEAR(measured.residual_rad / measured.rate_radpmps, -0.25, 1e-9);
      EXPECT_NEAR(measured.rate_radpmps, 4.0 * bend_radpm, 1e-9) << "5 m at 1.25 m/s take 4 s";
    }
  }
}

TEST(TurnSpeed, has_the_variance_of_noise_map_scale_and_bias_by_hand) {
  TurnSpeed turn = known(3e-4);
  TurnSpeed::Step s = step(0.01, 1.25, 1.25, 0.0);
  s.gyro_noise_radps_rthz = 1e-3;
  // Noise 1e-6 x 4; bias (3e-4 x 4)^2; map 5e-4^2; 1 % of 0.05 rad.
  const double once = 4e-6 + 2.5e-7 + 2.5e-7;
  EXPECT_NEAR(next(turn, s).variance_rad2, once + 1.44e-6, 1e-12);
  EXPECT_NEAR(next(turn, s).variance_rad2, once + 2.0 * 1.44e-6, 1e-12) << "the same bias again";
}

TEST(TurnSpeed, says_nothing_in_a_straight_passage) {
  TurnSpeed turn = known();
  const auto measured = next(turn, step(0.0, 1.0, 2.0, 0.1));
  EXPECT_EQ(measured.rate_radpmps, 0.0);
  EXPECT_NEAR(measured.residual_rad, 0.0, 1e-12);
}

// The turn of the first half of the window was that of the wrong speed. Counted as an error of the
// corrected one, it would be corrected twice.
TEST(TurnSpeed, does_not_count_again_what_another_measurement_has_corrected) {
  TurnSpeed turn = known();
  for (int k = 0; k < 20; ++k) ASSERT_FALSE(turn.add(step(0.01, 1.0, 1.5, 0.0), kUp));
  TurnSpeed::Step corrected = step(0.01, 1.0, 1.0, 0.0);
  corrected.correction_mps = -0.5;
  ASSERT_FALSE(turn.add(corrected, kUp));
  EXPECT_NEAR(next(turn, step(0.01, 1.0, 1.0, 0.0)).residual_rad, 0.0, 1e-12);
}

TEST(TurnSpeed, starts_anew_after_an_interruption) {
  TurnSpeed turn = known();
  for (int k = 0; k < 30; ++k) ASSERT_FALSE(turn.add(step(0.01, 1.0, 1.5, 0.0), kUp));
  turn.interrupt();
  EXPECT_NEAR(next(turn, step(0.01, 1.0, 1.0, 0.0)).residual_rad, 0.0, 1e-12);
}

}  // namespace
}  // namespace rali::odometry
