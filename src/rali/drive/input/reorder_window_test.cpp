#include "rali/drive/input/reorder_window.hpp"

#include <gtest/gtest.h>

namespace rali::drive {
namespace {

sensor::ImuSample imu(double t_s) {
  sensor::ImuSample s;
  s.t = Time::from_s(t_s);
  return s;
}

std::shared_ptr<const sensor::LidarScan> scan(double t_s) {
  auto s = std::make_shared<sensor::LidarScan>();
  s->t_end = Time::from_s(t_s);
  return s;
}

TEST(ReorderWindow, holds_events_until_a_0_5_s_newer_one_arrives) {
  ReorderWindow window;
  EXPECT_TRUE(window.push(Time::from_s(1.0), imu(1.0)));
  EXPECT_FALSE(window.pop());
  EXPECT_TRUE(window.push(Time::from_s(1.49), imu(1.49)));
  EXPECT_FALSE(window.pop());
  EXPECT_TRUE(window.push(Time::from_s(1.5), imu(1.5)));
  EXPECT_EQ(window.pop()->first, Time::from_s(1.0));
  EXPECT_FALSE(window.pop());
}

TEST(ReorderWindow, sorts_events_that_arrive_out_of_order) {
  ReorderWindow window;
  for (const double t : {2.0, 1.8, 1.9, 1.7}) EXPECT_TRUE(window.push(Time::from_s(t), imu(t)));
  window.finish();
  double last = 0.0;
  for (int i = 0; i < 4; ++i) {
    const auto event = window.pop();
    ASSERT_TRUE(event);
    EXPECT_GT(event->first.s(), last);
    last = event->first.s();
  }
  EXPECT_FALSE(window.pop());
}

TEST(ReorderWindow, outputs_inertial_samples_before_a_scan_of_the_same_time) {
  ReorderWindow window;
  EXPECT_TRUE(window.push(Time::from_s(1.0), scan(1.0)));
  EXPECT_TRUE(window.push(Time::from_s(1.0), imu(1.0)));
  window.finish();
  EXPECT_TRUE(std::holds_alternative<sensor::ImuSample>(window.pop()->second));
  EXPECT_FALSE(std::holds_alternative<sensor::ImuSample>(window.pop()->second));
}

TEST(ReorderWindow, drops_and_counts_events_older_than_the_last_output) {
  ReorderWindow window;
  (void)window.push(Time::from_s(1.0), imu(1.0));
  (void)window.push(Time::from_s(2.0), imu(2.0));
  ASSERT_TRUE(window.pop());
  EXPECT_FALSE(window.push(Time::from_s(0.9), imu(0.9)));
  EXPECT_EQ(window.late(), 1U);
  EXPECT_TRUE(window.push(Time::from_s(1.2), imu(1.2))) << "still in time";
}

}  // namespace
}  // namespace rali::drive
