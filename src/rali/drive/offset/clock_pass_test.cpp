#include "rali/drive/offset/clock_pass.hpp"

#include <gtest/gtest.h>

namespace rali::drive {
namespace {

ClockOffset estimate(double value_s, double sigma_s) {
  ClockOffset offset;
  offset.value_s = value_s;
  offset.sigma_s = sigma_s;
  return offset;
}

TEST(ClockFindings, name_a_clock_that_differs_by_0_1_s_and_five_sigma) {
  EXPECT_FALSE(other_clock_finding("v2", "v1", estimate(0.09, 0.001))) << "a radio's latency";
  EXPECT_FALSE(other_clock_finding("v2", "v1", estimate(0.3, 0.07)));
  EXPECT_FALSE(other_clock_finding("v2", "v1", ClockOffset{})) << "not known";
  const auto ahead = other_clock_finding("v2", "v1", estimate(-0.3, 0.05));
  ASSERT_TRUE(ahead);
  EXPECT_EQ(ahead->id, "D17");
  EXPECT_EQ(ahead->vehicle, "v2");
  EXPECT_EQ(ahead->severity, Severity::kWarning);
  EXPECT_NE(ahead->text.find("0.30 s ahead of that of v1"), std::string::npos) << ahead->text;
  const auto behind = other_clock_finding("v2", "v1", estimate(0.3, 0.05));
  ASSERT_TRUE(behind);
  EXPECT_NE(behind->text.find("0.30 s behind that of v1"), std::string::npos) << behind->text;
}

TEST(ClockFindings, warn_only_if_the_offset_was_not_found) {
  ClockOffset unknown;
  unknown.origin = "not found: too few ranges";
  const Finding warning = clock_offset_finding("v2", "v1", unknown);
  EXPECT_EQ(warning.severity, Severity::kWarning);
  EXPECT_NE(warning.text.find("too few ranges"), std::string::npos);
  EXPECT_NE(warning.remedy.find("vehicles.v2.clock_offset_s"), std::string::npos);
  EXPECT_EQ(clock_offset_finding("v2", "v1", estimate(-1.0, 0.02)).severity, Severity::kInfo);
}

TEST(ClockEvidence, starts_a_new_piece_after_a_loss) {
  using vehicle::PoseQuality;
  ClockEvidence evidence;
  evidence.add(Time::from_s(1.0), {}, PoseQuality::kGood, false);
  evidence.add(Time::from_s(2.0), {}, PoseQuality::kDiverged, false);
  evidence.add(Time::from_s(3.0), {}, PoseQuality::kWeak, true);
  ASSERT_EQ(evidence.poses.size(), 2U);
  EXPECT_NE(evidence.poses[0].piece, evidence.poses[1].piece);
  EXPECT_TRUE(evidence.poses[1].degenerate);
}

}  // namespace
}  // namespace rali::drive
