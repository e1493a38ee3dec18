#include "rali/drive/input/imu_fitness.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace rali::drive {
namespace {

std::vector<Time> times(double start_s, double end_s, double hz) {
  std::vector<Time> out;
  for (int i = 0; start_s + i / hz < end_s; ++i) out.push_back(Time::from_s(start_s + i / hz));
  return out;
}

std::string reported(const std::vector<Time>& imu) {
  return unfit_inertial(times(100.0, 103.0, 10.0), imu).value_or("");
}

TEST(ImuFitness, accepts_usual_rates_and_early_or_late_starts) {
  for (const double hz : {50.0, 100.0, 200.0, 1000.0})
    EXPECT_EQ(reported(times(99.9, 103.0, hz)), "");
  EXPECT_EQ(reported(times(0.0, 101.0, 100.0)), "") << "ran a minute before the LiDAR was on";
  EXPECT_EQ(reported(times(102.5, 103.0, 100.0)), "") << "came up late";
  EXPECT_EQ(reported(times(104.0, 105.0, 100.0)), "") << "comes soon after the first scans";
}

TEST(ImuFitness, rejects_fewer_than_two_samples_per_scan) {
  EXPECT_EQ(reported(times(100.0, 103.0, 1.0)),
            "inertial data come at 1.0 Hz, too slow to be integrated");
  EXPECT_EQ(reported(times(100.0, 103.0, 19.0)),
            "inertial data come at 19.0 Hz, too slow to be integrated");
  EXPECT_EQ(reported(times(100.0, 103.0, 21.0)), "");
}

TEST(ImuFitness, reports_the_time_gap_of_data_outside_the_scans) {
  EXPECT_EQ(reported(times(130.0, 133.0, 100.0)),
            "inertial data lie wholly after the scans, by 27.1 s");
  EXPECT_EQ(reported(times(70.0, 73.0, 100.0)),
            "inertial data lie wholly before the scans, by 27.0 s");
}

TEST(ImuFitness, accepts_too_few_samples_to_decide) {
  EXPECT_FALSE(unfit_inertial({}, times(0.0, 1.0, 1.0)));
  EXPECT_FALSE(unfit_inertial(times(0.0, 1.0, 10.0), {}));
  EXPECT_EQ(reported({Time::from_s(101.0)}), "");
  EXPECT_EQ(reported({Time::from_s(101.0), Time::from_s(101.0), Time::from_s(102.0)}), "");
}

}  // namespace
}  // namespace rali::drive
