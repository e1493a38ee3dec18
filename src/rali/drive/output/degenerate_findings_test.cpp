#include "rali/drive/output/degenerate_findings.hpp"

#include <gtest/gtest.h>

namespace rali::drive {
namespace {

/// Ten scans a second, a position with sigma `sigma_m` along x.
void add(std::vector<PoseRecord>& poses, double until_s, HeldBy held_by, double sigma_m,
         double grows_mps = 0.0) {
  const double from_s = poses.empty() ? 0.0 : poses.back().t.s() + 0.1;
  for (double t_s = from_s; t_s < until_s - 1e-6; t_s += 0.1) {
    PoseRecord pose;
    pose.t = Time::from_s(t_s);
    pose.degenerate = held_by != HeldBy::kLidar;
    pose.held_by = held_by;
    const double sigma = sigma_m + grows_mps * (t_s - from_s);
    pose.covariance.diagonal().setConstant(1e-6);
    pose.covariance(3, 3) = sigma * sigma;
    poses.push_back(pose);
  }
}

TEST(DegenerateFindings, report_the_degenerate_interval_and_the_resulting_position_sigma) {
  std::vector<PoseRecord> poses;
  add(poses, 40.0, HeldBy::kLidar, 0.01);
  add(poses, 48.0, HeldBy::kNothing, 0.01, 0.2);
  add(poses, 100.0, HeldBy::kLidar, 1.6);
  const FindingList found = degenerate_findings(poses, "v2");
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].id, "odometry.degenerate");
  EXPECT_EQ(found[0].vehicle, "v2");
  EXPECT_NEAR(found[0].t.s(), 40.0, 0.11);
  EXPECT_NEAR(found[0].t_end.s(), 47.9, 0.11);
  EXPECT_NE(found[0].text.find("from 40 to 48 s"), std::string::npos) << found[0].text;
  EXPECT_NE(found[0].text.find("known to 1.6 m"), std::string::npos) << found[0].text;
}

TEST(DegenerateFindings, split_a_long_interval_into_parts_of_a_tenth_of_the_run) {
  std::vector<PoseRecord> poses;
  add(poses, 10.0, HeldBy::kLidar, 0.01);
  add(poses, 100.0, HeldBy::kNothing, 0.01, 0.1);
  const FindingList found = degenerate_findings(poses, "v1");
  ASSERT_GE(found.size(), 8U);
  for (std::size_t k = 0; k < found.size(); ++k) {
    EXPECT_LE(seconds_between(found[k].t, found[k].t_end), 10.2);
    if (k > 0) {
      EXPECT_EQ(found[k].t, found[k - 1].t_end) << "nothing is left out";
      EXPECT_GT(found[k].value, found[k - 1].value);
    }
  }
}

TEST(DegenerateFindings, are_empty_if_ranges_constrain_or_the_sigma_stays_small) {
  std::vector<PoseRecord> held, brief, standing;
  add(held, 100.0, HeldBy::kRange, 0.4);
  EXPECT_TRUE(degenerate_findings(held, "v1").empty());
  add(brief, 50.0, HeldBy::kLidar, 0.01);
  add(brief, 53.0, HeldBy::kImu, 0.01, 0.05);
  add(brief, 100.0, HeldBy::kLidar, 0.1);
  EXPECT_TRUE(degenerate_findings(brief, "v1").empty());
  // No better known before: a vehicle with a start pose of 0.5 m sigma, at standstill.
  add(standing, 100.0, HeldBy::kImu, 0.5);
  EXPECT_TRUE(degenerate_findings(standing, "v1").empty());
  EXPECT_TRUE(degenerate_findings({}, "v1").empty());
}

TEST(DegenerateFindings, merge_intervals_separated_by_1_s_of_observability) {
  std::vector<PoseRecord> poses;
  add(poses, 50.0, HeldBy::kLidar, 0.01);
  add(poses, 53.0, HeldBy::kNothing, 0.01, 0.2);
  add(poses, 54.0, HeldBy::kLidar, 0.6);
  add(poses, 57.0, HeldBy::kNothing, 0.6, 0.2);
  add(poses, 100.0, HeldBy::kLidar, 1.2);
  EXPECT_EQ(degenerate_findings(poses, "v1").size(), 1U);
}

}  // namespace
}  // namespace rali::drive
