#include "rali/config/old_keys.hpp"

#include <algorithm>
#include <fstream>
#include <set>

#include <gtest/gtest.h>

#include "rali/config/load_fleet.hpp"

namespace rali::config {
namespace {

std::string settings_of_version_0_1() {
  std::ifstream file(std::string(RALI_SOURCE_DIR) + "/tests/corpus/yaml/settings_0_1.yaml");
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::size_t notices_with(const FleetConfig& config, std::string_view text) {
  return static_cast<std::size_t>(std::count_if(
      config.notices.begin(), config.notices.end(),
      [&](const std::string& notice) { return notice.find(text) != std::string::npos; }));
}

TEST(OldKeys, of_version_0_1_are_loaded_into_the_new_settings) {
  const auto config = parse_fleet(settings_of_version_0_1(), "settings.yaml", "", {});
  ASSERT_TRUE(config) << config.error().message();
  const RoomSettings& s = config->settings;
  EXPECT_EQ(s.ranging.mixture.uncertainty_m, 0.5);
  EXPECT_EQ(s.ranging.finder.report_sigmas, 4.0);
  EXPECT_EQ(s.ranging.finder.samples_max, 120) << "a key that keeps its name in a renamed group";
  EXPECT_EQ(s.fleet.separator.moved_sigma, 2.5);
  EXPECT_EQ(s.fleet.separator.kept, 50);
  EXPECT_EQ(s.map.dynamic.pass_fraction, 0.3);
  EXPECT_EQ(s.odometry.robust.initialisation.rest.window_s, 2.0);
  EXPECT_EQ(s.odometry.robust.initialisation.rest_travel_max_m, 0.2);
  EXPECT_FALSE(s.ranging.sight.use);
  EXPECT_FALSE(s.fleet.joint.sight);
  EXPECT_EQ(s.mission.rest_s, 2.0);
  EXPECT_EQ(s.odometry.robust.map.voxel_m, 0.7) << "an old key that is still a key";
}

TEST(OldKeys, have_one_notice_each_with_line_and_new_name) {
  const auto config = parse_fleet(settings_of_version_0_1(), "settings.yaml", "", {});
  ASSERT_TRUE(config) << config.error().message();
  const std::set<std::string> different(config->notices.begin(), config->notices.end());
  EXPECT_EQ(different.size(), config->notices.size());
  EXPECT_EQ(notices_with(*config, " was removed and is ignored. "), 13U);
  EXPECT_EQ(notices_with(*config,
                         ": settings.ranging.mixture.doubt_m is called "
                         "settings.ranging.mixture.uncertain_m now."),
            1U);
  for (const std::string& notice : config->notices) {
    EXPECT_TRUE(notice.starts_with("settings.yaml:")) << notice;
  }
}

TEST(OldKeys, on_the_command_line_work_with_and_without_settings_prefix) {
  for (const char* key : {"settings.ranging.sight.use", "ranging.sight.use"}) {
    const auto config = parse_fleet("vehicles: {v1: {recording: a.bag}}", "fleet.yaml", "",
                                    {"", {std::string(key) + "=false"}});
    ASSERT_TRUE(config) << config.error().message();
    EXPECT_FALSE(config->settings.ranging.sight.use) << key;
    ASSERT_EQ(config->notices.size(), 1U);
    EXPECT_TRUE(config->notices[0].starts_with("command line: settings.ranging.sight.use "));
  }
}

TEST(OldKeys, are_overridden_by_the_new_key) {
  const auto config = parse_fleet(
      "vehicles: {v1: {recording: a.bag}}\n"
      "settings: {ranging: {line_of_sight: {end_m: 0.7}, sight: {end_m: 0.9, surfaces: 3}}}",
      "fleet.yaml", "", {});
  ASSERT_TRUE(config) << config.error().message();
  EXPECT_EQ(config->settings.ranging.sight.end_m, 0.7);
  EXPECT_EQ(config->settings.ranging.sight.surfaces, 3);
}

TEST(OldKeys, are_dumped_under_valid_new_names) {
  // A renamed key without a valid target would make the file of version 0.1 unreadable.
  const auto config = parse_fleet(settings_of_version_0_1(), "settings.yaml", "", {});
  ASSERT_TRUE(config) << config.error().message();
  const std::string written = dump_fleet(*config, "");
  EXPECT_TRUE(parse_fleet(written, "again.yaml", "", {}));
  EXPECT_TRUE(parse_fleet(written, "again.yaml", "", {})->notices.empty());
}

}  // namespace
}  // namespace rali::config
