#include "rali/assess/limits.hpp"

#include <gtest/gtest.h>

#include "rali/assess/evaluate_words.hpp"
#include "rali/assess/stamps.hpp"

namespace rali::assess {
namespace {

Evaluation two_vehicles() {
  Evaluation e;
  for (const double rmse : {0.1, 0.4}) {
    VehicleScore v;
    v.name = rmse < 0.2 ? "v1" : "v2";
    v.trajectory.poses = 10;
    v.trajectory.ape_m.rmse = rmse;
    v.trajectory.drift = eval::Drift{2.0 * rmse, 0.0, 10.0, -rmse};
    v.trajectory.degenerate = DegenerateScore{};
    e.vehicles.push_back(v);
  }
  e.fleet = e.vehicles[0].trajectory;
  e.fleet.drift.reset();
  e.fleet.ape_m.rmse = 0.3;
  e.fleet.rpe.push_back({10.0, {}, {}});
  e.fleet.rpe[0].translation_m.count = 5;
  e.fleet.rpe[0].translation_m.rmse = 0.05;
  return e;
}

std::size_t broken(const std::string& text) {
  const auto limit = parse_limit(text);
  return limit ? broken_limits({*limit}, two_vehicles()).size() : 99;
}

TEST(Limits, are_violated_by_larger_values_and_met_by_equal_ones) {
  EXPECT_EQ(broken("ape_rmse_m=0.3"), 0U);
  EXPECT_EQ(broken("ape_rmse_m=0.29"), 1U);
  EXPECT_EQ(broken("v1:ape_rmse_m=0.2"), 0U);
  EXPECT_EQ(broken("v2:ape_rmse_m=0.2"), 1U);
  EXPECT_EQ(broken("rpe_10m_rmse_m=0.05"), 0U);
  EXPECT_EQ(broken("drift_final_m=0.7"), 1U);  // of the worst vehicle: 0.8
  EXPECT_EQ(broken("drift_z_m=0.4"), 0U);
  EXPECT_EQ(broken("drift_z_m=0.39"), 1U);
}

TEST(Limits, without_degeneracy_are_met_and_on_unmeasured_values_are_violated) {
  EXPECT_EQ(broken("along_degenerate_rmse_m=0"), 0U);
  EXPECT_EQ(broken("nees_mean=100"), 1U);
  EXPECT_EQ(broken("c2m_mean_m=100"), 1U);
  EXPECT_EQ(broken("rpe_50m_rmse_m=100"), 1U);
  EXPECT_EQ(broken("v9:ape_rmse_m=100"), 1U);
}

TEST(Limits, with_an_old_name_check_the_metric_of_the_new_name) {
  const auto limit = parse_limit("v1:along_blind_rmse_m=0.5");
  ASSERT_TRUE(limit);
  EXPECT_EQ(limit->name, "along_degenerate_rmse_m");
}

TEST(Limits, violated_are_reported_with_the_measured_value) {
  const auto limit = parse_limit("v2:ape_rmse_m=0.2");
  ASSERT_TRUE(limit);
  EXPECT_EQ(broken_limits({*limit}, two_vehicles())[0], "limit v2:ape_rmse_m=0.2: it is 0.4");
}

TEST(Limits, with_invalid_syntax_are_refused) {
  for (const char* text :
       {"ape=1", "ape_rmse_m", "ape_rmse_m=", "ape_rmse_m=-1", "ape_rmse_m=nan", "ape_rmse_m=1x",
        "rpe_m_rmse_m=1", "rpe_-1m_rmse_m=1", "", "=", ":", "v1:c2m_mean_m=1"}) {
    const auto limit = parse_limit(text);
    ASSERT_FALSE(limit) << text;
    EXPECT_EQ(limit.error().code, ErrorCode::kUsage);
  }
}

TEST(Words, of_options_for_distances_association_and_pose_are_parsed) {
  EXPECT_EQ(parse_distances("1,10, 10,50").value(), (std::vector<double>{1, 10, 50}));
  for (const char* text : {"", "0", "1,", "-1", "nan", "1,,2", "a"}) {
    EXPECT_FALSE(parse_distances(text)) << text;
  }
  EXPECT_EQ(parse_association("nearest:0.02")->max_dt_s, 0.02);
  EXPECT_EQ(parse_association("interpolate")->mode, eval::AssociationMode::kInterpolate);
  for (const char* text : {"", "nearest:", "nearest:-1", "near", "nearest:nan"}) {
    EXPECT_FALSE(parse_association(text)) << text;
  }
  EXPECT_NEAR(parse_pose("1,2,3,0,0,90")->R(1, 0), 1.0, 1e-12);
  EXPECT_FALSE(parse_pose("1,2,3"));
  EXPECT_FALSE(parse_pose("1,2,3,4,5,inf"));
}

eval::PoseList span(double start_s, double end_s) {
  return {{Time::from_s(start_s), {}}, {Time::from_s(end_s), {}}};
}

std::string cause(const eval::PoseList& est, const eval::PoseList& truth,
                  const eval::AssociationOptions& options = {}) {
  const Error e = no_common_time(est, "est.tum", truth, "truth.tum", options);
  EXPECT_EQ(e.code, ErrorCode::kInput);
  return e.message();
}

TEST(NoCommonTime, reports_both_time_spans_and_the_likely_cause) {
  const std::string text = cause(span(1.7e9, 1.7e9 + 60), span(0, 60e3));
  EXPECT_NE(text.find("1700000000.000 .. 1700000060.000 s against 0.000 .. 60000.000 s"),
            std::string::npos);
  EXPECT_NE(text.find("milliseconds"), std::string::npos);
  EXPECT_NE(cause(span(0.5, 60.5), span(1e8, 1e8 + 6e7)).find("microseconds"), std::string::npos);
  EXPECT_NE(cause(span(7, 67), span(1.7e9, 1.7e9 + 50)).find("from 1970"), std::string::npos);
  EXPECT_NE(cause(span(1.7e9, 1.7e9 + 60), span(1.7e9 + 7200, 1.7e9 + 7260)).find("time zone"),
            std::string::npos);
  EXPECT_NE(cause(span(1.7e9, 1.7e9 + 60), span(1.7e9 + 3e5, 1.7e9 + 3e5 + 60)).find("3.5 days"),
            std::string::npos);
  EXPECT_NE(cause(span(1.7e9, 1.7e9 + 60), span(1.7e9 + 90, 1.7e9 + 150)).find("shifted"),
            std::string::npos);
  EXPECT_NE(cause(span(10, 20), span(9.95, 20.05)).find("no stamps are within 0.01 s"),
            std::string::npos);
}

}  // namespace
}  // namespace rali::assess
