#include "rali/drive/output/metrics.hpp"

#include <limits>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace rali::drive {
namespace {

MapSummary two_vehicles() {
  MapSummary summary;
  for (const char* name : {"v1", "läufer"}) {
    summary.vehicles.emplace_back();
    summary.vehicles.back().name = name;
  }
  summary.ranges.pairs.push_back({});
  summary.ranges.pairs.back().name = "v1-läufer";
  return summary;
}

nlohmann::json pair_of(const MapSummary& summary, const MapJob& job) {
  return nlohmann::json::parse(metrics_text(summary, job))["ranges"]["pairs"]["v1-läufer"];
}

TEST(Metrics, contain_the_range_latency_estimated_by_either_vehicle_of_a_pair) {
  MapSummary summary = two_vehicles();
  EXPECT_TRUE(pair_of(summary, {})["latency_s"].is_null());
  summary.vehicles[1].input.range_latency = RangeLatency{0.046, 0.005};
  EXPECT_EQ(pair_of(summary, {})["latency_s"], 0.046);
  EXPECT_EQ(pair_of(summary, {})["latency_sigma_s"], 0.005);
  MapJob given;
  given.ranges.latency_s = 0.03;
  EXPECT_EQ(pair_of(summary, given)["latency_s"], 0.03) << "as set";
  EXPECT_TRUE(pair_of(summary, given)["latency_sigma_s"].is_null());
}

TEST(Metrics, contain_the_measured_and_the_stated_imu_noise) {
  MapSummary summary = two_vehicles();
  summary.vehicles[0].input.has_imu = true;
  summary.vehicles[0].imu_noise.accel_mps2_rthz = 0.108;
  summary.vehicles[0].imu_noise_stated = {0.003, 0.03};
  const auto vehicles = nlohmann::json::parse(metrics_text(summary, {}))["vehicles"];
  const auto& noise = vehicles["v1"]["imu_noise"];
  EXPECT_EQ(noise["accel_mps2_rthz"], 0.108);
  EXPECT_EQ(noise["accel_stated_mps2_rthz"], 0.03);
  EXPECT_TRUE(noise["gyro_radps_rthz"].is_null()) << "it did not drive long enough";
  EXPECT_EQ(noise["gyro_stated_radps_rthz"], 0.003);
  EXPECT_TRUE(vehicles["läufer"]["imu_noise"].is_null()) << "no inertial data";
}

TEST(Metrics, contain_no_tilt_sigma_for_an_unlevelled_frame) {
  MapSummary summary = two_vehicles();
  summary.vehicles[0].levelled = true;
  summary.vehicles[1].tilt_sigma_rad = std::numeric_limits<double>::quiet_NaN();
  const auto json = nlohmann::json::parse(metrics_text(summary, {}))["vehicles"];
  EXPECT_EQ(json["v1"]["T_map_odom"]["levelled"], true);
  EXPECT_EQ(json["läufer"]["T_map_odom"]["levelled"], false);
  EXPECT_TRUE(json["läufer"]["T_map_odom"]["tilt_sigma_rad"].is_null());
}

}  // namespace
}  // namespace rali::drive
