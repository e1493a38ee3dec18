#include "rali/config/public_settings.hpp"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "rali/config/load_fleet.hpp"

namespace rali::config {
namespace {

FieldList all_fields(FleetConfig& config) {
  config.vehicles.emplace_back();
  return fleet_fields(config, "");
}

TEST(PublicSettings, are_at_most_60_existing_settings_each_in_one_group) {
  FleetConfig config;
  const FieldList fields = all_fields(config);
  std::set<std::string_view> listed;
  for (const SymptomGroup& group : public_settings()) {
    for (const std::string_view key : group.keys) {
      EXPECT_TRUE(listed.insert(key).second) << key << " is in two groups";
      EXPECT_TRUE(std::any_of(fields.begin(), fields.end(),
                              [&](const Field& field) { return field.key == key; }))
          << key << " is no setting";
    }
  }
  EXPECT_LE(listed.size(), kPublicSettingsMax);
  const auto marked = std::count_if(fields.begin(), fields.end(), [](const Field& field) {
    return field.visibility == Visibility::kPublic;
  });
  EXPECT_EQ(static_cast<std::size_t>(marked), listed.size());
}

TEST(PublicSettings, of_a_vehicle_are_public_for_any_vehicle_name) {
  EXPECT_TRUE(is_public_setting("vehicles.left.lidar.topic"));
  EXPECT_FALSE(is_public_setting("vehicles.left.imu.noise.gyro_radps_rthz"));
  EXPECT_FALSE(is_public_setting("settings.ranging.gate.chi2"));
}

TEST(PublicSettings, the_full_manual_has_all_settings_and_the_help_of_groups) {
  FleetConfig config;
  const std::string manual = settings_manual(SettingsShown::kAll);
  for (const Field& field : all_fields(config)) {
    EXPECT_NE(manual.find("`" + field.key + "`"), std::string::npos) << field.key;
  }
  EXPECT_NE(manual.find("## settings.ranging.line_of_sight: walls of the map between the antennas"),
            std::string::npos);
}

TEST(PublicSettings, do_not_exclude_unstable_keys_and_unknown_keys_get_a_suggestion) {
  const std::string fleet = "vehicles: {v1: {recording: a.bag}}";
  EXPECT_TRUE(parse_fleet(fleet, "f", "", {"", {"ranging.gate.chi2=9"}}));
  const auto wrong = parse_fleet(fleet, "f", "", {"", {"ranging.gate.chi=9"}});
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().message().find("Did you mean 'chi2'?"), std::string::npos)
      << wrong.error().message();
}

}  // namespace
}  // namespace rali::config
