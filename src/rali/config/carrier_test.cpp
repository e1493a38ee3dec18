#include <gtest/gtest.h>

#include "rali/config/load_fleet.hpp"

namespace rali::config {
namespace {

Result<FleetConfig> parse(const std::string& settings, const Overrides& overrides = {}) {
  return parse_fleet("vehicles: {v1: {recording: a.bag}}\n" + settings, "fleet.yaml", "",
                     overrides);
}

odometry::ConstraintSettings constraints_of(const std::string& settings,
                                            const Overrides& overrides = {}) {
  const Result<FleetConfig> config = parse(settings, overrides);
  EXPECT_TRUE(config) << config.error().message();
  return config ? config->settings.odometry.robust.constraints : odometry::ConstraintSettings{};
}

TEST(Carrier, sets_motion_bounds_and_constraints) {
  const odometry::ConstraintSettings ground = constraints_of("");
  EXPECT_TRUE(ground.non_holonomic && ground.ground && ground.standstill);
  const auto drone = constraints_of("settings: {odometry: {robust: {carrier: drone}}}");
  EXPECT_FALSE(drone.non_holonomic || drone.ground || drone.standstill);
  EXPECT_GT(drone.speed_usual_mps, ground.speed_usual_mps);
  EXPECT_GT(drone.accel_max_mps2, ground.accel_max_mps2);
  const auto hand = constraints_of("", {"", {"odometry.robust.carrier=handheld"}});
  EXPECT_FALSE(hand.non_holonomic || hand.ground);
  EXPECT_TRUE(hand.standstill) << "it may be put down";
  EXPECT_LT(hand.speed_max_mps, ground.speed_max_mps);
}

TEST(Carrier, values_yield_to_explicit_settings_in_file_or_command_line) {
  const std::string file =
      "settings: {odometry: {robust: {constraints: {ground: true, speed_usual_mps: 9}, "
      "carrier: drone}}}";
  const auto given = constraints_of(file);
  EXPECT_TRUE(given.ground);
  EXPECT_EQ(given.speed_usual_mps, 9.0);
  EXPECT_FALSE(given.non_holonomic) << "not given: the drone's";
  const auto typed = constraints_of(file, {"",
                                           {"odometry.robust.constraints.speed_max_mps=3",
                                            "settings.odometry.robust.carrier=handheld"}});
  EXPECT_EQ(typed.speed_max_mps, 3.0);
  EXPECT_EQ(typed.speed_usual_mps, 9.0);
  EXPECT_TRUE(typed.standstill) << "the command line's carrier holds, not the file's";
}

TEST(Carrier, is_recorded_as_origin_of_its_values_and_unknown_names_fail) {
  const auto config = parse("settings: {odometry: {robust: {carrier: drone}}}");
  ASSERT_TRUE(config);
  EXPECT_EQ(config->origins.at("settings.odometry.robust.constraints.ground"), "carrier drone");
  const auto again = parse_fleet(dump_fleet(*config, ""), "settings.yaml", "", {});
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_EQ(hash_fleet(*again), hash_fleet(*config)) << "settings.yaml runs the same";
  const auto wrong = parse("settings: {odometry: {robust: {carrier: boat}}}");
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().message().find("handheld"), std::string::npos) << wrong.error().message();
}

}  // namespace
}  // namespace rali::config
