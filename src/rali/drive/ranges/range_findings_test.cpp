#include "rali/drive/ranges/range_findings.hpp"

#include <gtest/gtest.h>

namespace rali::drive {
namespace {

using ranging::RangeReason;

RangeLog log_of(double first_s, double last_s) {
  RangeLog log({"v1", "v2"});
  for (const double t_s : {first_s, last_s}) {
    sensor::RangeSample sample;
    sample.t = Time::from_s(t_s);
    sample.from = VehicleId{0};
    sample.to = VehicleId{1};
    log.add_refused(sample, RangeReason::kNoPose);
  }
  return log;
}

/// Two vehicles with data from 100 to 200 s and from 150 to 260 s, and one without any.
FindingList findings_of(double first_s, double last_s, bool placing = false) {
  MapJob job;
  job.vehicles.resize(3);
  std::vector<InputReport> reports(3);
  reports[0].scans = reports[1].scans = 10;
  reports[0].t_start = Time::from_s(100.0);
  reports[0].t_end = Time::from_s(200.0);
  reports[1].t_start = Time::from_s(150.0);
  reports[1].t_end = Time::from_s(260.0);
  return range_findings(log_of(first_s, last_s).tally(), job, reports, placing);
}

TEST(RangeFindings, reports_ranges_stamped_by_another_clock) {
  const FindingList before = findings_of(3.0, 99.0);
  ASSERT_EQ(before.size(), 1U);
  EXPECT_EQ(before[0].id, "ranges.other_clock");
  EXPECT_EQ(before[0].text,
            "none of 2 ranges was used: they are stamped 3.000 to 99.000 s, the recordings "
            "100.000 to 260.000 s");
  ASSERT_EQ(findings_of(3700.0, 3800.0).size(), 1U);
  EXPECT_EQ(findings_of(3700.0, 3800.0)[0].id, "ranges.other_clock");
}

TEST(RangeFindings, does_not_report_another_clock_if_the_times_touch) {
  ASSERT_EQ(findings_of(90.0, 100.0).size(), 1U);
  EXPECT_EQ(findings_of(90.0, 100.0)[0].id, "ranges.none_used");
  EXPECT_EQ(findings_of(260.0, 300.0)[0].id, "ranges.none_used");
}

// "None was used", beside "placed by ranges", looked like broken radios.
TEST(RangeFindings, ranges_that_only_placed_the_vehicles_are_no_fault) {
  const FindingList list = findings_of(120.0, 180.0, true);
  ASSERT_EQ(list.size(), 1U);
  EXPECT_EQ(list[0].severity, Severity::kInfo);
  EXPECT_EQ(list[0].text,
            "2 ranges placed the vehicles relative to each other; none corrected a vehicle while "
            "it drove, 2 of them for no_pose");
  EXPECT_EQ(findings_of(120.0, 180.0)[0].severity, Severity::kWarning);
}

}  // namespace
}  // namespace rali::drive
