#include "rali/inspect/stamp_study.hpp"

#include <functional>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::inspect {
namespace {

std::vector<drive::StampPair> ticking(int n, double period_s, double offset_s = 0.0) {
  std::vector<drive::StampPair> stamps;
  for (int i = 0; i < n; ++i) {
    const Time t = Time::from_s(1000.0 + i * period_s);
    stamps.push_back({t + Duration::from_s(offset_s), t + Duration::from_s(0.002)});
  }
  return stamps;
}

const Finding* find(const FindingList& findings, const std::string& id, const std::string& words) {
  for (const Finding& f : findings) {
    if (f.id == id && f.text.find(words) != std::string::npos) return &f;
  }
  return nullptr;
}

TEST(StampStudy, regular_10_hz_stamps_have_no_warning) {
  const StampStatistics s = study_stamps(ticking(100, 0.1));
  EXPECT_NEAR(s.rate_hz(), 10.0, 1e-6);
  EXPECT_NEAR(s.span_s, 9.9, 1e-6);
  EXPECT_EQ(s.missing, 0U);
  FindingList findings;
  report_rate(s, "D01", "scans", "/points", findings);
  report_stamps(s, "/points", findings);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].severity, Severity::kInfo);
}

TEST(StampStudy, three_missing_scans_are_reported_with_time_and_gap_length) {
  auto stamps = ticking(100, 0.1);
  stamps.erase(stamps.begin() + 50, stamps.begin() + 53);
  const StampStatistics s = study_stamps(stamps);
  EXPECT_EQ(s.missing, 3U);
  EXPECT_NEAR(s.longest_gap_s, 0.4, 1e-6);
  EXPECT_NEAR(s.t_longest_gap.s(), 1004.9, 1e-6);
  FindingList findings;
  report_rate(s, "D01", "scans", "/points", findings);
  const Finding* gap = find(findings, "D01", "missing");
  ASSERT_NE(gap, nullptr);
  EXPECT_EQ(gap->severity, Severity::kWarning);
  EXPECT_NEAR(gap->value, 0.4, 1e-6);
}

TEST(StampStudy, jitter_is_not_taken_for_loss) {
  auto stamps = ticking(4000, 0.005);
  Rng rng(3, "jitter");
  for (auto& s : stamps) s.header = s.header + Duration::from_s(0.002 * rng.normal());
  EXPECT_LT(study_stamps(stamps).missing, 8U) << "0.2 %";
  stamps.erase(stamps.begin() + 1000, stamps.begin() + 1400);
  EXPECT_NEAR(static_cast<double>(study_stamps(stamps).missing), 400.0, 8.0);
}

TEST(StampStudy, zero_header_stamps_are_replaced_by_record_times) {
  auto stamps = ticking(100, 0.1);
  for (auto& stamp : stamps) stamp.header = Time{};
  const StampStatistics s = study_stamps(stamps);
  EXPECT_EQ(s.decision.rule, drive::StampRule::kRecord);
  EXPECT_NEAR(s.rate_hz(), 10.0, 1e-6);
  FindingList findings;
  report_stamps(s, "/points", findings);
  EXPECT_NE(find(findings, "D04", "record"), nullptr);
}

TEST(StampStudy, repeats_and_backward_steps_are_counted) {
  auto stamps = ticking(100, 0.1);
  stamps[20].header = stamps[19].header;
  std::swap(stamps[40].header, stamps[41].header);
  const StampStatistics s = study_stamps(stamps);
  EXPECT_EQ(s.repeated, 1U);
  EXPECT_EQ(s.backward, 1U);
}

TEST(StampStudy, lidar_and_imu_on_different_clocks_are_an_error) {
  FindingList findings;
  report_clock_split(study_stamps(ticking(100, 0.1)), study_stamps(ticking(100, 0.005, -900.0)),
                     "/imu", findings);
  const Finding* split = find(findings, "D04", "two clocks");
  ASSERT_NE(split, nullptr);
  EXPECT_EQ(split->severity, Severity::kError);
  EXPECT_NEAR(split->value, -900.0, 0.01);
}

TEST(StampStudy, no_messages_and_one_message_do_not_divide_by_zero) {
  FindingList findings;
  report_rate(study_stamps({}), "D01", "scans", "/points", findings);
  report_rate(study_stamps(ticking(1, 0.1)), "D01", "scans", "/points", findings);
  ASSERT_EQ(findings.size(), 2U);
  EXPECT_EQ(findings[0].severity, Severity::kError);
}

}  // namespace
}  // namespace rali::inspect
