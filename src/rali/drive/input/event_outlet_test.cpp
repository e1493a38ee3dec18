#include "rali/drive/input/event_outlet.hpp"

#include <gtest/gtest.h>

namespace rali::drive {
namespace {

sensor::ImuSample imu_at(double t_s) {
  sensor::ImuSample sample;
  sample.t = Time::from_s(t_s);
  return sample;
}

sensor::RangeSample range_at(double t_s) {
  sensor::RangeSample sample;
  sample.t = Time::from_s(t_s);
  return sample;
}

std::shared_ptr<const sensor::LidarScan> scan_at(double t_s) {
  auto scan = std::make_shared<sensor::LidarScan>();
  scan->t_start = Time::from_s(t_s - 0.1);
  scan->t_end = Time::from_s(t_s);
  scan->push_back(1.0F, 0.0F, 0.0F, 1.0F, 0.0F, 0);
  return scan;
}

/// The events passed on: i, s or r with their times in milliseconds.
std::string left(EventOutlet& outlet, InputReport& report) {
  std::string text;
  while (auto event = outlet.pop(report)) {
    if (const auto* imu = std::get_if<sensor::ImuSample>(&*event)) {
      text += 'i' + std::to_string(imu->t.ns / 1'000'000) + ' ';
    } else if (const auto* range = std::get_if<sensor::RangeSample>(&*event)) {
      text += 'r' + std::to_string(range->t.ns / 1'000'000) + ' ';
    } else {
      text += "s ";
    }
  }
  return text;
}

TEST(EventOutlet, outputs_ranges_in_time_order_between_inertial_samples_and_scans) {
  EventOutlet outlet(InputOptions{});
  InputReport report;
  for (const double t_s : {1.0, 1.1, 1.2, 2.0}) outlet.push(imu_at(t_s));
  outlet.push(scan_at(1.2));
  outlet.push(range_at(1.2));
  outlet.push(range_at(1.05));
  EXPECT_EQ(left(outlet, report), "i1000 r1050 i1100 i1200 r1200 s ");
  outlet.finish();
  EXPECT_EQ(left(outlet, report), "i2000 ");
  EXPECT_EQ(report.ranges, 2U);
  EXPECT_EQ(report.imu_samples, 4U);
}

TEST(EventOutlet, a_range_with_a_wrong_clock_does_not_advance_the_ordering_window) {
  EventOutlet outlet(InputOptions{});
  InputReport report;
  outlet.push(imu_at(1.0));
  outlet.push(range_at(4e9));
  EXPECT_EQ(left(outlet, report), "") << "the window has not passed";
  outlet.push(imu_at(1.3));
  outlet.push(imu_at(1.2));
  outlet.finish();
  EXPECT_EQ(left(outlet, report), "i1000 i1200 i1300 r4000000000000 ");
  EXPECT_EQ(report.gaps.late, 0U);
}

TEST(EventOutlet, a_late_range_is_still_output_to_be_reported) {
  EventOutlet outlet(InputOptions{});
  InputReport report;
  outlet.push(imu_at(1.0));
  outlet.push(imu_at(2.0));
  EXPECT_EQ(left(outlet, report), "i1000 ");
  outlet.push(range_at(0.5));
  EXPECT_EQ(left(outlet, report), "") << "with the next event";
  outlet.finish();
  EXPECT_EQ(left(outlet, report), "r500 i2000 ");
}

TEST(EventOutlet, late_scans_are_damage_but_few_late_inertial_samples_are_not) {
  for (const bool scan_late : {false, true}) {
    EventOutlet outlet(InputOptions{});
    InputReport report;
    for (int i = 0; i < 400; ++i) {
      outlet.push(imu_at(1.0 + 0.01 * i));
      (void)left(outlet, report);
    }
    outlet.push(imu_at(2.0));
    if (scan_late) outlet.push(scan_at(2.0));
    outlet.finish();
    (void)left(outlet, report);
    outlet.close(report);
    EXPECT_EQ(report.gaps.late, scan_late ? 2U : 1U);
    EXPECT_EQ(report.gaps.damaged, scan_late);
    ASSERT_FALSE(report.findings.empty());
    EXPECT_NE(report.findings.back().text.find(scan_late ? "1 of 1 scan and 1 of 401 inertial"
                                                         : "1 of 401 inertial samples came"),
              std::string::npos)
        << report.findings.back().text;
  }
}

TEST(EventOutlet, drops_ranges_outside_the_requested_time) {
  InputOptions options;
  options.start_s = 1.0;
  options.duration_s = 1.0;
  EventOutlet outlet(options);
  InputReport report;
  outlet.push(range_at(10.0));  // does not define the start of the data
  for (const double t_s : {11.0, 12.5, 14.0}) outlet.push(imu_at(t_s));
  for (const double t_s : {11.5, 12.2, 13.5}) outlet.push(range_at(t_s));
  outlet.finish();
  EXPECT_EQ(left(outlet, report), "r12200 i12500 ");
  EXPECT_TRUE(outlet.past_end());
}

}  // namespace
}  // namespace rali::drive
