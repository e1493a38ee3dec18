// Absurd values for every setting: each ends with exit code 2 and one sentence that names the key,
// before any data are read.

#include <algorithm>
#include <cstdio>
#include <sstream>

#include <gtest/gtest.h>

#include "rali/cli/app.hpp"
#include "rali/cli/command.hpp"
#include "rali/cli/run_for_test.hpp"

namespace rali::cli {
namespace {

/// A row of the tables of `rali help-settings --all`.
struct Setting {
  std::string key, bounds;

  [[nodiscard]] bool is_number() const { return bounds.find(" to ") != std::string::npos; }
};

std::vector<Setting> all_settings() {
  std::vector<Setting> settings;
  std::istringstream lines(run_rali({"help-settings", "--all"}).out);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("| `")) continue;
    const std::size_t end = line.find('`', 3), bounds = line.find(" | ", line.find(" | ", end) + 3);
    settings.push_back({line.substr(3, end - 3),
                        line.substr(bounds + 3, line.find(" | ", bounds + 3) - bounds - 3)});
  }
  return settings;
}

/// The recording does not exist: an accepted value would end with another sentence.
std::string refused(const Setting& setting, const std::string& value) {
  const Outcome run =
      run_rali({"map", "v1.bag", "-o", "nowhere", "--set", setting.key + '=' + value});
  const bool one_line = std::count(run.err.begin(), run.err.end(), '\n') == 1;
  const bool named = run.err.find("command line") != std::string::npos;
  const bool good = run.code == kExitNotStarted && run.out.empty() && one_line && named &&
                    run.err.starts_with("rali: error: ");
  return good ? ""
              : setting.key + '=' + value + " gave " + std::to_string(run.code) + ": " + run.err;
}

TEST(HostileSettings, invalid_and_out_of_bounds_numbers_are_refused) {
  std::size_t numbers = 0;
  for (const Setting& setting : all_settings()) {
    if (!setting.is_number()) continue;
    ++numbers;
    for (const char* value :
         {"nan", ".nan", "inf", "-.inf", "1e400", "1e308", "-1e9", "abc", "true", "", "[[1]]",
          "'1'x", "99999999999999999999999", "0x10", "1_0"}) {
      EXPECT_EQ(refused(setting, value), "");
    }
  }
  EXPECT_GT(numbers, 100U) << "the table of help-settings is read wrongly";
}

TEST(HostileSettings, malformed_yaml_values_of_any_key_are_refused) {
  for (const Setting& setting : all_settings()) {
    for (const char* value : {"[1,2", "\"x", "{a: b", "&a [*a]", "*b"}) {
      EXPECT_EQ(refused(setting, value), "");
    }
  }
}

TEST(HostileSettings, invalid_keys_are_refused) {
  const std::string deep(100000, '.');
  for (const std::string& key :
       {std::string("nokey"), std::string(""), std::string(".."), std::string("vehicles..x"),
        std::string("vehicles.v1.nothing"), std::string("settings.map.grid.cell_m.x"), deep}) {
    EXPECT_EQ(refused({key, ""}, "1"), "");
  }
  EXPECT_EQ(refused({"output.map_voxel_m", ""}, std::string(20000, '[')), "");
  EXPECT_EQ(refused({"output.map_voxel_m", ""}, "0.1\nschema: 1"), "");
}

TEST(HostileSettings, invalid_elements_of_lists_and_poses_are_refused) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"vehicles.v1.lidar.range_m", "[100, 0.4]"},
      {"vehicles.v1.lidar.range_m", "[nan, 1]"},
      {"vehicles.v1.lidar.range_m", "[1]"},
      {"vehicles.v1.self_box_m", "[1, -1, 0, 1, 0, 1]"},
      {"vehicles.v1.lidar.T_body_lidar", "{xyz_m: [0, 0, .nan]}"},
      {"vehicles.v1.lidar.T_body_lidar", "{xyz_m: [1e300, 0, 0]}"},
      {"vehicles.v1.lidar.T_body_lidar", "{quat_xyzw: [0, 0, 0, 0]}"},
      {"vehicles.v1.lidar.T_body_lidar", "{matrix: [[1, 0, 0], [0, 1, 0], [0, 0, -1]]}"},
      {"output.grid.z_m", "[2, 1]"},
      {"ranges.limits_m", "[200, 0.2]"},
  };
  for (const auto& [key, value] : cases) EXPECT_EQ(refused({key, ""}, value), "");
}

}  // namespace
}  // namespace rali::cli
