#include "rali/drive/run_findings.hpp"

#include <gtest/gtest.h>

namespace rali::drive {
namespace {

VehicleSummary measured(double accel, double gyro) {
  VehicleSummary vehicle;
  vehicle.name = "v1";
  vehicle.imu_noise = {gyro, accel};
  vehicle.imu_noise_stated = {0.003, 0.03};
  return vehicle;
}

TEST(NoiseFindings, reports_stated_noise_that_is_far_from_the_measured_noise) {
  const FindingList low = noise_findings(measured(0.108, 0.003));
  ASSERT_EQ(low.size(), 1U);
  EXPECT_EQ(low[0].text,
            "accelerometer noise while driving is 0.11 m/s2/rtHz, 3.6 times what imu.noise states");
  EXPECT_EQ(low[0].effect, "the measured value is used");
  EXPECT_EQ(low[0].severity, Severity::kInfo) << "it harms nothing";
  EXPECT_EQ(low[0].vehicle, "v1");
  const FindingList high = noise_findings(measured(0.03, 0.0006));
  ASSERT_EQ(high.size(), 1U);
  EXPECT_EQ(high[0].text,
            "gyro noise while driving is 0.0006 rad/s/rtHz, 0.2 times what imu.noise states");
}

TEST(NoiseFindings, reports_nothing_within_a_factor_of_3_or_without_a_measurement) {
  EXPECT_TRUE(noise_findings(measured(0.085, 0.0011)).empty());
  VehicleSummary standing = measured(0.0, 0.0);
  standing.imu_noise = {};
  EXPECT_TRUE(noise_findings(standing).empty());
}

}  // namespace
}  // namespace rali::drive
