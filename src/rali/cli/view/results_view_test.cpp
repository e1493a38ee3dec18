#include "rali/cli/view/results_view.hpp"

#include <cmath>
#include <cstring>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "rali/wire/decode.hpp"

namespace rali::cli {
namespace {

using nlohmann::json;

/// v1 is at standstill at the origin, v2 drives 1 m/s along y from second 2 to 12, in round 1 of
/// v1.
report::RunData small_run() {
  report::RunData run;
  run.name = "out";
  run.vehicles.resize(2);
  run.vehicles[0].name = "v1";
  run.vehicles[1].name = "v2";
  for (int i = 0; i <= 100; ++i) {
    const double t_s = 2.0 + 0.1 * i;
    run.vehicles[0].path.push_back({t_s, {0, 0, 0}});
    run.vehicles[1].path.push_back({t_s, {5, 0.1 * i, 0}});
    report::DegeneracyPoint point;
    point.t_s = t_s;
    point.axis = {0, 1, 0};
    point.degenerate = i >= 50;
    run.vehicles[1].degeneracy.push_back(point);
    report::SigmaPoint sigma;
    sigma.t_s = t_s;
    sigma.cov_m2 = {0.01F, 0, 0, 0.09F, 0, 0.01F};
    run.vehicles[1].sigmas.push_back(sigma);
  }
  report::Round round;
  round.round = "1";
  round.anchor = "v1";
  round.start_s = 0.0;
  round.end_s = 20.0;
  run.rounds = {round};
  run.warnings = {{"fleet.loop", "v2", "A loop was refused."}};
  run.map.x_m = {1, 2};
  run.map.y_m = {3, 4};
  run.map.z_m = {5, 6};
  run.map.vehicle = {0, 1};
  return run;
}

TEST(ResultsView, the_last_state_holds_poses_sigma_degeneracy_and_anchor) {
  const json state = json::parse(results_state(small_run()));
  EXPECT_EQ(state["vehicle"], "out");
  EXPECT_NEAR(state["t_s"], 12.0, 1e-9);
  EXPECT_EQ(state["anchor"]["vehicle"], "v1");
  EXPECT_NEAR(state["mission"]["distance_m"], 10.0, 1e-6);
  const json& v2 = state["vehicles"][1];
  EXPECT_NEAR(v2["position_m"][1], 10.0, 1e-9);
  EXPECT_NEAR(v2["yaw_rad"], std::acos(0.0), 1e-9);
  EXPECT_NEAR(v2["ellipse"]["major_m"], 0.3, 1e-6);
  EXPECT_NEAR(v2["ellipse"]["minor_m"], 0.1, 1e-6);
  EXPECT_NEAR(v2["ellipse"]["angle_rad"], std::acos(0.0), 1e-6);
  EXPECT_EQ(v2["degenerate"]["axis"], json({0.0, 1.0, 0.0}));
  EXPECT_EQ(v2["role"], "tag");
  EXPECT_EQ(state["diagnostics"][0]["message"], "A loop was refused.");
}

TEST(ResultsView, the_history_covers_first_to_last_pose) {
  const json states = json::parse(results_history(small_run()))["states"];
  ASSERT_EQ(states.size(), 11U);
  EXPECT_NEAR(states.front()["t_s"], 2.0, 1e-9);
  EXPECT_NEAR(states.back()["t_s"], 12.0, 1e-9);
  EXPECT_FALSE(states.front()["vehicles"][1].contains("degenerate"));
  EXPECT_TRUE(states[8]["vehicles"][1].contains("degenerate"));
}

TEST(ResultsView, paths_state_where_they_were_degenerate) {
  const json path = json::parse(results_paths(small_run()))["paths"][1];
  EXPECT_EQ(path["vehicle"], "v2");
  ASSERT_EQ(path["t_s"].size(), 101U);
  EXPECT_EQ(path["degenerate"][49], 0);
  EXPECT_EQ(path["degenerate"][50], 1);
}

TEST(ResultsView, the_cloud_is_a_valid_point_cloud2_message) {
  const wire::Bytes bytes = results_cloud(small_run(), {});
  const auto cloud = wire::decode_point_cloud2(bytes, wire::Encoding::kCdr);
  ASSERT_TRUE(cloud);
  EXPECT_EQ(cloud->width, 2U);
  ASSERT_EQ(cloud->fields.size(), 4U);
  EXPECT_EQ(cloud->fields[3].name, "vehicle");
  const wire::Bytes timed = results_cloud(small_run(), {3.0F, std::nanf("")});
  const auto with_age = wire::decode_point_cloud2(timed, wire::Encoding::kCdr);
  ASSERT_TRUE(with_age);
  ASSERT_EQ(with_age->fields.size(), 5U);
  float age_s = 0.0F;
  std::memcpy(&age_s, with_age->data.data() + 13, sizeof age_s);
  EXPECT_FLOAT_EQ(age_s, 9.0F) << "seen at 3 s, the run ends at 12 s";
}

TEST(ResultsView, a_run_without_poses_map_or_rounds_gives_valid_json) {
  report::RunData run;
  run.name = "out\xFF";
  run.vehicles.resize(1);
  run.vehicles[0].name = "v1";
  run.vehicles[0].in_map = false;
  EXPECT_EQ(json::parse(results_state(run))["vehicles"][0]["frame"], "local");
  EXPECT_EQ(json::parse(results_history(run))["states"].size(), 2U);
  EXPECT_TRUE(json::parse(results_paths(run))["paths"].empty());
}

TEST(ResultsView, a_vehicle_that_ended_earlier_keeps_its_last_position) {
  report::RunData run = small_run();
  run.vehicles[0].path.resize(20);
  const json state = json::parse(results_state(run));
  EXPECT_NEAR(state["vehicles"][0]["age_s"], 8.1, 1e-6);
  EXPECT_NEAR(state["vehicles"][0]["position_m"][0], 0.0, 1e-9);
}

}  // namespace
}  // namespace rali::cli
