#include "rali/drive/offset/clock_offset.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::drive {
namespace {

using geometry::Vec3;

constexpr double kTurn_s = 20.0;  ///< one vehicle drives, the others stand

/// Vehicle v drives 10 m to and fro, on a line of its own, in every `vehicles`-th turn.
Vec3 position(std::size_t v, std::size_t vehicles, double t_s) {
  const double cycle_s = kTurn_s * static_cast<double>(vehicles);
  const double in_cycle_s = std::fmod(t_s, cycle_s) - kTurn_s * static_cast<double>(v);
  const double phase = std::clamp((in_cycle_s - 2.0) / (kTurn_s - 4.0), 0.0, 1.0);
  return {5.0 - 5.0 * std::cos(2.0 * M_PI * phase),
          4.0 * static_cast<double>(v) + std::sin(2.0 * M_PI * phase), 0.0};
}

/// A fleet whose clocks are ahead of the true time.
struct Fleet {
  std::vector<double> ahead_s;
  double latency_s = 0.0;
  double duration_s = 120.0;

  [[nodiscard]] std::vector<ClockEvidence> evidence() const {
    std::vector<ClockEvidence> all(ahead_s.size());
    for (std::size_t v = 0; v < all.size(); ++v) {
      all[v].antennas_body_m = {Vec3(0.0, 0.0, 0.5)};
      for (double t_s = 0.0; t_s < duration_s; t_s += 0.1) {
        ClockPose pose;
        pose.t = Time::from_s(t_s + ahead_s[v]);
        pose.T_odom_body.p = position(v, all.size(), t_s);
        all[v].poses.push_back(pose);
      }
    }
    return all;
  }

  /// Between all pairs, 10 per second, stamped by one clock.
  [[nodiscard]] std::vector<sensor::RangeSample> ranges(std::uint16_t clock) const {
    Rng rng(3, "clock");
    std::vector<sensor::RangeSample> out;
    for (double t_s = 1.0; t_s < duration_s - 1.0; t_s += 0.1) {
      for (std::size_t b = 1; b < ahead_s.size(); ++b) {
        for (std::size_t a = 0; a < b; ++a) {
          sensor::RangeSample sample;
          sample.clock = VehicleId{clock};
          sample.t = Time::from_s(t_s + latency_s + ahead_s[clock]);
          sample.from = VehicleId{static_cast<std::uint16_t>(a)};
          sample.to = VehicleId{static_cast<std::uint16_t>(b)};
          sample.range_m =
              (position(a, ahead_s.size(), t_s) - position(b, ahead_s.size(), t_s)).norm() + 0.1 +
              0.07 * rng.normal();
          out.push_back(sample);
        }
      }
    }
    return out;
  }
};

TEST(ClockOffset, of_a_second_vehicle_by_ranges_that_the_first_has_stamped) {
  for (const double ahead_s : {-4.2}) {
    const Fleet fleet{{0.0, ahead_s}};
    const auto ranges = fleet.ranges(0);
    const auto offsets = judge_clock_offsets(fleet.evidence(), ranges, {});
    ASSERT_EQ(offsets.size(), 2U);
    EXPECT_EQ(offsets[0].value_s, 0.0);
    ASSERT_TRUE(offsets[1].sigma_s) << offsets[1].origin;
    EXPECT_NEAR(offsets[1].value_s, -ahead_s, 0.015);
    EXPECT_NEAR(offsets[1].value_s, -ahead_s, 4.0 * *offsets[1].sigma_s);
  }
}

TEST(ClockOffset, is_apart_from_the_latency_of_the_ranges) {
  const Fleet fleet{{0.0, 0.5}, 0.06};
  const auto ranges = fleet.ranges(0);
  const auto offsets = judge_clock_offsets(fleet.evidence(), ranges, {});
  ASSERT_TRUE(offsets[1].sigma_s) << offsets[1].origin;
  EXPECT_NEAR(offsets[1].value_s, -0.5, 0.02) << "not -0.44: the first vehicle shows the latency";
}

TEST(ClockOffset, of_three_vehicles_by_ranges_of_any_of_them) {
  const Fleet fleet{{0.0, 1.2, -0.8}};
  const auto ranges = fleet.ranges(1);
  const auto offsets = judge_clock_offsets(fleet.evidence(), ranges, {});
  ASSERT_TRUE(offsets[1].sigma_s) << offsets[1].origin;
  ASSERT_TRUE(offsets[2].sigma_s) << offsets[2].origin;
  EXPECT_NEAR(offsets[1].value_s, -1.2, 0.02);
  EXPECT_NEAR(offsets[2].value_s, 0.8, 0.02);
}

TEST(ClockOffset, that_is_given_is_not_estimated_again) {
  const Fleet fleet{{0.0, 0.0, 0.7}};
  auto evidence = fleet.evidence();
  evidence[1].known = true;
  const auto ranges = fleet.ranges(0);
  const auto offsets = judge_clock_offsets(evidence, ranges, {});
  EXPECT_EQ(offsets[1].value_s, 0.0);
  EXPECT_TRUE(offsets[1].origin.empty());
  EXPECT_NEAR(offsets[2].value_s, -0.7, 0.02);
}

TEST(ClockOffset, is_not_found_without_ranges_on_another_clock) {
  const Fleet fleet{{0.0, 0.35}};
  for (const auto& ranges : {std::vector<sensor::RangeSample>{}, fleet.ranges(1)}) {
    auto evidence = fleet.evidence();
    std::erase_if(evidence[0].poses, [](const ClockPose& p) { return p.t > Time::from_s(20.0); });
    const auto offsets = judge_clock_offsets(evidence, ranges, {});
    EXPECT_EQ(offsets[1].value_s, 0.0);
    EXPECT_FALSE(offsets[1].sigma_s);
    EXPECT_NE(offsets[1].origin.find("too few ranges"), std::string::npos) << offsets[1].origin;
  }
}

TEST(ClockOffset, beyond_the_search_is_not_found) {
  const Fleet fleet{{0.0, 300.0}};
  const auto ranges = fleet.ranges(0);
  EXPECT_FALSE(judge_clock_offsets(fleet.evidence(), ranges, {})[1].sigma_s);
}

TEST(ClockOffset, ignores_ranges_of_strangers_and_of_no_number) {
  const Fleet fleet{{0.0, 0.35}};
  auto ranges = fleet.ranges(0);
  for (std::size_t i = 0; i < ranges.size(); i += 7) {
    ranges[i].range_m = std::nan("");
    ranges[i + 1].to = VehicleId{0x8005};
    ranges[i + 2].to_antenna = 9;
  }
  const auto offsets = judge_clock_offsets(fleet.evidence(), ranges, {});
  ASSERT_TRUE(offsets[1].sigma_s) << offsets[1].origin;
  EXPECT_NEAR(offsets[1].value_s, -0.35, 0.02);
}

}  // namespace
}  // namespace rali::drive
