#include "rali/inspect/fleet_study.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::inspect {
namespace {

using geometry::Vec3;

/// Drives past a peer at (8, 6, 0) and back, at 1 to 2 m/s.
Vec3 driven(double t_s) {
  return {10.0 - 10.0 * std::cos(0.15 * t_s), 1.5 * std::sin(0.3 * t_s), 0.0};
}

std::vector<ranging::TrackPoint> track_of(double end_s) {
  std::vector<ranging::TrackPoint> track;
  for (int k = 0; 0.1 * k < end_s; ++k)
    track.push_back({Time::from_s(0.1 * k), driven(0.1 * k), 0});
  return track;
}

std::vector<ranging::TrackPoint> standing(double end_s) {
  std::vector<ranging::TrackPoint> track = track_of(end_s);
  for (ranging::TrackPoint& point : track) point.p_odom_m = Vec3(0.01, 0.0, 0.0);
  return track;
}

RangeStudy ranges_with(double latency_s, double end_s) {
  RangeStudy study;
  Rng rng(7, "ranges");
  for (double t_s = 0.0; t_s < end_s; t_s += 0.05) {
    double range_m = (driven(t_s) - Vec3(8.0, 6.0, 0.4)).norm() + 0.2 + 0.08 * rng.normal();
    if (rng.uniform() < 0.05) range_m += 3.0;  // behind an obstacle
    study.add(Time::from_s(t_s + latency_s), "v1", "v2", range_m);
  }
  return study;
}

DoctorReport report_of(const std::string& name, std::vector<ranging::TrackPoint> track) {
  DoctorReport report;
  report.vehicle = name;
  report.t_start = track.front().t;
  report.t_end = track.back().t;
  report.track = std::move(track);
  return report;
}

TEST(FleetStudy, range_latency_is_estimated_from_motion_past_a_standing_peer) {
  for (const double latency_s : {0.0, 0.046, 0.15, -0.08}) {
    const auto ranges = ranges_with(latency_s, 60.0).between("v1", "v2");
    const auto found = latency_by_motion(track_of(60.0), ranges);
    ASSERT_TRUE(found) << latency_s;
    EXPECT_NEAR(found->value_s, latency_s, 4.0 * found->sigma_s);
    EXPECT_NEAR(found->value_s, latency_s, 0.015);
    EXPECT_LT(found->sigma_s, 0.015);
  }
}

TEST(FleetStudy, range_latency_is_not_observable_without_motion_or_enough_ranges) {
  EXPECT_FALSE(latency_by_motion(standing(60.0), ranges_with(0.05, 60.0).between("v1", "v2")));
  const auto few = ranges_with(0.05, 1.5).between("v1", "v2");
  EXPECT_FALSE(latency_by_motion(track_of(60.0), few));
}

TEST(FleetStudy, finding_d16_reports_latency_or_that_it_is_not_observable) {
  FindingList findings;
  report_latency({report_of("v1", track_of(60.0)), report_of("v2", standing(60.0))},
                 ranges_with(0.1, 60.0), findings);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].id, "D16");
  EXPECT_EQ(findings[0].severity, Severity::kWarning);
  EXPECT_NEAR(findings[0].value, 0.1, 0.01);
  findings.clear();
  report_latency({report_of("v1", track_of(60.0)), report_of("v2", track_of(60.0))},
                 ranges_with(0.1, 60.0), findings);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_NE(findings[0].text.find("not observable"), std::string::npos) << "both drive";
}

TEST(FleetStudy, finding_d16_assigns_numbered_radios_to_the_recording_vehicle) {
  RangeStudy study;
  study.add_radio("/uwb", "v1", 3, false);
  study.add_radio("/uwb", "v2", 5, false);
  study.add(Time::from_s(2.0), "3", "5", 4.0);
  study.add(Time::from_s(1.0), "5", "3", 5.0);
  const auto both = study.between("v1", "v2");
  ASSERT_EQ(both.size(), 2U);
  EXPECT_EQ(both[0].second, 5.0) << "by time";
  FindingList findings;
  report_latency({}, study, findings);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_NE(findings[0].text.find("no stamps"), std::string::npos);
}

Finding overlap(double start_s, double end_s, bool separate = false) {
  DoctorReport a = report_of("v1", track_of(60.0)), b = a;
  a.t_start = Time::from_s(1.7e9);
  a.t_end = Time::from_s(1.7e9 + 300.0);
  b.vehicle = "v2";
  b.t_start = Time::from_s(start_s);
  b.t_end = Time::from_s(end_s);
  FindingList findings;
  report_overlap({a, b}, separate, findings);
  EXPECT_EQ(findings.size(), 1U);
  return findings.front();
}

TEST(FleetStudy, finding_d17_reports_the_time_overlap_of_two_vehicles) {
  EXPECT_EQ(overlap(1.7e9 + 61.0, 1.7e9 + 400.0).text,
            "v2 starts 61.0 s after v1; both run for 239 s");
  EXPECT_EQ(overlap(1.7e9 + 61.0, 1.7e9 + 400.0).severity, Severity::kInfo);
  EXPECT_EQ(overlap(1.7e9 + 86400.0, 1.7e9 + 86500.0).severity, Severity::kWarning);
  EXPECT_EQ(overlap(1.7e9 + 86400.0, 1.7e9 + 86500.0, true).severity, Severity::kInfo);
  const Finding boot = overlap(7403.0, 7700.0);
  EXPECT_EQ(boot.severity, Severity::kError);
  EXPECT_NE(boot.text.find("different origins"), std::string::npos);
}

TEST(DoctorYaml, ranges_and_antennas_are_written_with_notes_on_missing_values) {
  RangeStudy study;
  study.add_radio("/uwb", "v1", 3, false);
  study.add_radio("/uwb", "v2", 5, false);
  study.add_peer("/uwb", 3);
  study.add_peer("/uwb", 9);
  const std::string yaml =
      doctor_fleet_yaml({report_of("v1", track_of(1.0)), report_of("v2", track_of(1.0))},
                        {{"r.csv"}, {}, {}, {}, false}, study);
  EXPECT_NE(yaml.find("antennas: {uwb: {xyz_m: [0, 0, 0]}}  # measure"), std::string::npos) << yaml;
  EXPECT_NE(yaml.find("- {file: \"r.csv\"}"), std::string::npos) << yaml;
  EXPECT_NE(yaml.find("- {topic: \"/uwb\", ids: {3: v1, 5: v2}}"), std::string::npos) << yaml;
  EXPECT_NE(yaml.find("# radio 9 is in no recording"), std::string::npos) << yaml;
}

}  // namespace
}  // namespace rali::inspect
