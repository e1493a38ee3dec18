#include "rali/sensor/lidar_models.hpp"

#include <numbers>

#include <gtest/gtest.h>

namespace rali::sensor {
namespace {

constexpr float kRad = std::numbers::pi_v<float> / 180.0F;

std::vector<float> elevations_rad(std::string_view model, float error_deg = 0.0F) {
  std::vector<float> angles;
  float sign = 1.0F;
  for (const float deg : find_lidar_model(model)->elevations_deg) {
    angles.push_back((deg + sign * error_deg) * kRad);
    sign = -sign;
  }
  return angles;
}

TEST(LidarModels, elevations_ascend_and_their_number_matches_the_model) {
  for (const LidarModel& model : lidar_models()) {
    for (std::size_t i = 1; i < model.elevations_deg.size(); ++i) {
      EXPECT_LT(model.elevations_deg[i - 1], model.elevations_deg[i]) << model.name << " " << i;
    }
    if (model.spinning && model.name != "generic") {
      EXPECT_EQ(model.lines, model.elevations_deg.size()) << model.name;
      EXPECT_GT(model.lines, 0) << model.name;
    }
  }
  EXPECT_EQ(find_lidar_model("hdl64e")->lines, 64);
  EXPECT_EQ(find_lidar_model("pandar40p")->lines, 40);
  EXPECT_EQ(find_lidar_model("os1_128")->lines, 128);
}

TEST(LidarModels, every_documented_name_is_found) {
  for (const char* name :
       {"vlp16",  "vlp32c", "hdl32e",  "hdl64e",    "os0_32", "os0_64", "os0_128",
        "os1_32", "os1_64", "os1_128", "rs16",      "rs32",   "helios", "helios16",
        "xt16",   "xt32",   "qt64",    "pandar40p", "mid360", "avia",   "generic"}) {
    EXPECT_NE(find_lidar_model(name), nullptr) << name;
    EXPECT_NE(lidar_model_names().find(name), std::string::npos) << name;
  }
  EXPECT_EQ(find_lidar_model("auto"), nullptr);
  EXPECT_EQ(find_lidar_model(""), nullptr);
}

TEST(LidarModels, nearest_ring_rounds_to_the_nearest_and_clamps_at_the_ends) {
  const std::vector<float> rings = {-0.2F, 0.0F, 0.1F};
  EXPECT_EQ(nearest_ring(rings, -9.0F), 0U);
  EXPECT_EQ(nearest_ring(rings, -0.11F), 0U);
  EXPECT_EQ(nearest_ring(rings, -0.09F), 1U);
  EXPECT_EQ(nearest_ring(rings, 0.06F), 2U);
  EXPECT_EQ(nearest_ring(rings, 9.0F), 2U);
}

TEST(LidarModels, a_model_is_identified_from_elevations_with_calibration_error) {
  for (const LidarModel& model : lidar_models()) {
    if (model.elevations_deg.empty()) continue;
    const LidarModel* found = identify_lidar(elevations_rad(model.name, 0.05F));
    ASSERT_NE(found, nullptr) << model.name;
    // Of models with the same angles the first is returned.
    EXPECT_EQ(std::vector<float>(found->elevations_deg.begin(), found->elevations_deg.end()),
              std::vector<float>(model.elevations_deg.begin(), model.elevations_deg.end()))
        << model.name << " taken for " << found->name;
  }
}

TEST(LidarModels, a_model_is_identified_without_outer_rings_but_not_from_half) {
  std::vector<float> rings = elevations_rad("vlp32c");
  rings.erase(rings.begin());
  rings.pop_back();
  ASSERT_NE(identify_lidar(rings), nullptr);
  EXPECT_EQ(identify_lidar(rings)->name, "vlp32c");
  rings.resize(12);
  EXPECT_EQ(identify_lidar(rings), nullptr);
}

TEST(LidarModels, unknown_elevations_match_no_model) {
  EXPECT_EQ(identify_lidar({}), nullptr);
  std::vector<float> odd;
  for (int i = 0; i < 16; ++i) odd.push_back((-40.0F + 5.0F * static_cast<float>(i)) * kRad);
  EXPECT_EQ(identify_lidar(odd), nullptr);
}

}  // namespace
}  // namespace rali::sensor
