#include <gtest/gtest.h>

#include "rali/config/load_fleet.hpp"

namespace rali::config {
namespace {

Result<FleetConfig> parse_live(std::string_view text) {
  Overrides overrides;
  overrides.live = true;
  return parse_fleet(text, "fleet.yaml", "/etc/rali", overrides);
}

TEST(LiveFields, a_live_vehicle_needs_no_recording) {
  const Result<FleetConfig> config = parse_live(
      "vehicles:\n  v1: {live: {address: 10.77.0.1, serial_port: /dev/ttyUSB0}}\n"
      "live: {ros_domain: 3, key_file: fleet.key, view_port: 8770}\n");
  ASSERT_TRUE(config) << config.error().message();
  EXPECT_EQ(config->vehicles[0].live.address, "10.77.0.1");
  EXPECT_EQ(config->vehicles[0].live.serial_port, "/dev/ttyUSB0");
  EXPECT_EQ(config->vehicles[0].live.serial_baud, 921600);
  EXPECT_EQ(config->live.ros_domain, 3);
  EXPECT_EQ(config->live.key_file, "/etc/rali/fleet.key");
  EXPECT_EQ(config->live.view_port, 8770);
  EXPECT_EQ(config->live.fleet_domain, 77);
}

TEST(LiveFields, an_unknown_key_of_the_live_section_is_an_error) {
  const Result<FleetConfig> config = parse_live("vehicles: {v1: {}}\nlive: {ros_domian: 3}\n");
  ASSERT_FALSE(config);
  EXPECT_NE(config.error().message().find("'ros_domain'"), std::string::npos)
      << config.error().message();
}

TEST(LiveFields, a_port_beyond_the_last_one_is_an_error) {
  EXPECT_FALSE(parse_live("vehicles: {v1: {}}\nlive: {view_port: 70000}\n"));
}

}  // namespace
}  // namespace rali::config
