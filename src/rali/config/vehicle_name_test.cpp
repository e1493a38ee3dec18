#include "rali/config/vehicle_name.hpp"

#include <gtest/gtest.h>

#include "rali/config/load_fleet.hpp"

namespace rali::config {
namespace {

TEST(VehicleName, keeps_letters_of_all_scripts) {
  for (const char* name : {"v1", "Größe_1", "läufer", "測試機", "тест-2", "🚗"}) {
    EXPECT_TRUE(is_vehicle_name(name)) << name;
    EXPECT_EQ(vehicle_name_from(name), name);
  }
}

TEST(VehicleName, replaces_each_unsafe_character_by_an_underscore) {
  EXPECT_EQ(vehicle_name_from("a/b c.d:e,f=g\nh"), "a_b_c_d_e_f_g_h");
  EXPECT_EQ(vehicle_name_from("-v"), "_v");
  EXPECT_EQ(vehicle_name_from("a\xC2\x85z"), "a_z") << "a control character";
  EXPECT_EQ(vehicle_name_from("a\xE2\x80\xAEz"), "a_z") << "right to left from here on";
  EXPECT_EQ(vehicle_name_from("a\xE3\x80\x80z"), "a_z") << "a wide space";
  EXPECT_EQ(vehicle_name_from(""), "v1");
  for (const char* name : {"", "-v", "a b", "a/b", "a\xE2\x80\xAEz"}) {
    EXPECT_FALSE(is_vehicle_name(name)) << name;
  }
}

TEST(VehicleName, replaces_invalid_utf8_bytes) {
  EXPECT_EQ(vehicle_name_from("a\xFFz"), "a_z");
  EXPECT_EQ(vehicle_name_from("a\xC3"), "a_") << "cut";
  EXPECT_EQ(vehicle_name_from("\xC0\xAF"), "__") << "a slash in two bytes";
  EXPECT_EQ(vehicle_name_from("\xED\xA0\x80"), "___") << "half of a pair";
  for (int lead = 0; lead < 256; ++lead) {
    for (int next = 0; next < 256; next += 5) {
      const std::string text = {static_cast<char>(lead), static_cast<char>(next), 'x'};
      EXPECT_TRUE(is_vehicle_name(vehicle_name_from(text))) << lead << ' ' << next;
    }
  }
}

TEST(VehicleName, is_truncated_to_32_characters_at_a_character_boundary) {
  std::string text;
  for (int i = 0; i < 40; ++i) text += "ü";
  EXPECT_EQ(vehicle_name_from(text).size(), 64U);
  EXPECT_TRUE(is_vehicle_name(vehicle_name_from(text)));
  EXPECT_FALSE(is_vehicle_name(text));
}

TEST(VehicleName, is_taken_from_the_file_name_and_kept_in_settings) {
  const auto config = fleet_of_recordings({"/data/Größe.bag", "測試.mcap", "a b:c.bag"}, {});
  ASSERT_TRUE(config) << config.error().message();
  EXPECT_EQ(config->vehicles[0].name, "Größe");
  EXPECT_EQ(config->vehicles[1].name, "測試");
  EXPECT_EQ(config->vehicles[2].name, "a_b_c");
  const auto again = parse_fleet(dump_fleet(*config, ""), "settings.yaml", "", {});
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_EQ(again->vehicles[0].name, "Größe");
}

}  // namespace
}  // namespace rali::config
