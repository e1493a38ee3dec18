#include "rali/inspect/range_study.hpp"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>

#include <gtest/gtest.h>

namespace rali::inspect {
namespace {

FindingList reported(const RangeStudy& study) {
  FindingList findings;
  study.report("ranges.csv", findings);
  return findings;
}

bool says(const FindingList& findings, const std::string& id, const std::string& words) {
  for (const Finding& f : findings) {
    if (f.id == id && f.text.find(words) != std::string::npos) return true;
  }
  return false;
}

RangeStudy both_directions(double bias_m) {
  RangeStudy study;
  for (int i = 0; i < 100; ++i) {
    study.add(Time::from_s(i * 0.1), "v1", "v2", 5.0 + 0.01 * i + bias_m);
    study.add(Time::from_s(i * 0.1 + 0.05), "v2", "v1", 5.0 + 0.01 * i);
  }
  return study;
}

TEST(RangeStudy, rate_per_pair_is_reported) {
  EXPECT_TRUE(says(reported(both_directions(0.0)), "D14", "v1->v2: 100 ranges, 10.0 Hz"));
}

TEST(RangeStudy, a_0_31_m_difference_between_directions_is_reported) {
  const FindingList findings = reported(both_directions(0.31));
  EXPECT_TRUE(says(findings, "D15", "v1->v2 is +0.3"));
}

TEST(RangeStudy, a_difference_between_directions_is_reported_at_2_hz) {
  RangeStudy study;
  for (int i = 0; i < 40; ++i) {
    study.add(Time::from_s(i * 0.5), "v1", "v2", 5.31 + 0.5 * i);
    study.add(Time::from_s(i * 0.5 + 0.1), "v2", "v1", 5.1 + 0.5 * i);
  }
  EXPECT_TRUE(says(reported(study), "D15", "v1->v2 is +0.31 m"));
}

TEST(RangeStudy, the_motion_between_two_ranges_is_no_bias) {
  RangeStudy study;  // two vehicles drive apart at 3 m/s: 0.15 m from one range to the next
  for (int i = 0; i < 100; ++i) {
    study.add(Time::from_s(i * 0.1), "v1", "v2", 5.0 + 0.3 * i);
    study.add(Time::from_s(i * 0.1 + 0.05), "v2", "v1", 5.0 + 0.3 * i + 0.15);
  }
  EXPECT_TRUE(says(reported(study), "D15", "v1->v2 is +0.00 m") ||
              says(reported(study), "D15", "v1->v2 is -0.00 m"));
}

TEST(RangeStudy, a_pair_without_ranges_is_reported) {
  RangeStudy study = both_directions(0.0);
  study.add(Time::from_s(1.0), "v2", "v3", 4.0);
  FindingList findings;
  study.report_silent({}, findings);
  EXPECT_TRUE(says(findings, "D14", "v1 and v3 never"));
  EXPECT_EQ(findings.size(), 1U);
}

TEST(RangeStudy, a_vehicle_without_any_range_is_reported) {
  FindingList findings;
  both_directions(0.0).report_silent({"v1", "v2", "v3"}, findings);
  ASSERT_EQ(findings.size(), 3U);
  EXPECT_TRUE(says(findings, "D14", "v1 and v3 never"));
  EXPECT_TRUE(says(findings, "D14", "v2 and v3 never"));
  EXPECT_TRUE(says(findings, "D14", "v3 measured no range"));
}

TEST(RangeStudy, antennas_of_one_vehicle_count_together_for_its_pairs) {
  RangeStudy study;
  study.add(Time::from_s(1.0), "v1/front", "v2", 4.0);
  study.add(Time::from_s(1.1), "v1/rear", "v3", 4.0);
  FindingList findings;
  study.report_silent({"v1", "v2", "v3"}, findings);
  ASSERT_EQ(findings.size(), 1U) << findings.back().text;
  EXPECT_TRUE(says(findings, "D14", "v2 and v3 never"));
}

TEST(RangeStudy, frozen_zero_and_impossible_values_are_counted) {
  RangeStudy study;
  for (int i = 0; i < 30; ++i) study.add(Time::from_s(i), "a", "b", 3.0);
  study.add(Time::from_s(31), "a", "b", 0.0);
  study.add(Time::from_s(32), "a", "b", -1.0);
  study.add(Time::from_s(33), "a", "b", std::numeric_limits<double>::quiet_NaN());
  const FindingList findings = reported(study);
  EXPECT_TRUE(says(findings, "D14", "the same value 30 times"));
  EXPECT_TRUE(says(findings, "D14", "1 distances are 0"));
  EXPECT_TRUE(says(findings, "D14", "2 ranges are negative"));
}

TEST(RangeStudy, the_number_of_stored_pairs_is_limited_to_1000) {
  RangeStudy study;
  for (int i = 0; i < 5000; ++i) study.add(Time::from_s(i), std::to_string(i), "x", 1.0);
  EXPECT_TRUE(says(reported(study), "D14", "more than 1000 pairs"));
}

TEST(RangesCsv, invalid_rows_are_reported_and_a_file_of_them_refused) {
  const auto path = std::filesystem::path(testing::TempDir()) / "range_study_bad.csv";
  std::ofstream(path) << "stamp_s,from,to,range_m\n1.0,v1,v2,3.0\n2.0,v1,v2,far\n";
  RangeStudy study;
  FindingList findings;
  EXPECT_TRUE(read_ranges_csv(path.string(), study, findings)) << "rali map reads on, too";
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_NE(findings[0].text.find(":3"), std::string::npos) << findings[0].text;
  std::ofstream(path) << "stamp_s,from,to,range_m\n2.0,v1,v2,far\n";
  const Status status = read_ranges_csv(path.string(), study, findings);
  std::filesystem::remove(path);
  ASSERT_FALSE(status.has_value());
  EXPECT_NE(status.error().where.find(":2"), std::string::npos) << status.error().where;
}

TEST(RangeStudy, ranges_of_a_pair_from_two_recordings_are_merged) {
  RangeStudy study;
  for (int i = 0; i < 100; ++i) study.add(Time::from_s(0.2 * i), "v1", "v2", 5.0 + 0.01 * i);
  for (int i = 0; i < 100; ++i) study.add(Time::from_s(0.2 * i + 0.1), "v1", "v2", 5.0 + 0.01 * i);
  EXPECT_TRUE(says(reported(study), "D14", "200 ranges, 10.0 Hz, longest gap 0.1 s"));
}

}  // namespace
}  // namespace rali::inspect
