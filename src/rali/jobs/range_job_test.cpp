#include "rali/jobs/range_job.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "rali/config/load_fleet.hpp"

namespace rali::jobs {
namespace {

config::FleetConfig fleet_of(std::string_view more) {
  const std::string text =
      "vehicles:\n"
      "  v1: {recording: a, antennas: {uwb: {xyz_m: [0.1, 0, 0.5]}, rear: {xyz_m: [-1, 0, 0]}}}\n"
      "  v2: {recording: b}\n" +
      std::string(more);
  const auto fleet = config::parse_fleet(text, "fleet.yaml", "", {});
  EXPECT_TRUE(fleet) << fleet.error().message();
  return fleet ? *fleet : config::FleetConfig{};
}

vehicle::VehicleSettings settings_of(const config::FleetConfig& fleet, std::size_t index) {
  vehicle::VehicleSettings settings;
  set_ranging(fleet, index, settings);
  return settings;
}

TEST(RangeJob, radio_names_and_ids_come_from_the_fleet_file) {
  const auto options = range_options(
      fleet_of("ranges: {sources: [{topic: /uwb, ids: {0: v1/rear, 7: v2}}], limits_m: [1, 50],\n"
               "         latency_s: 0.02, stamp: record}\n"));
  ASSERT_TRUE(options) << options.error().message();
  EXPECT_EQ(options->names.at("v1/rear"), (io::RadioEnd{VehicleId{0}, 1}));
  EXPECT_EQ(options->names.at("v2"), (io::RadioEnd{VehicleId{1}, 0}));
  const drive::RangeTopic* const topic = options->topic_of("/uwb");
  ASSERT_NE(topic, nullptr);
  EXPECT_EQ(topic->ids.at(0), (io::RadioEnd{VehicleId{0}, 1}));
  EXPECT_EQ(topic->ids.at(7), (io::RadioEnd{VehicleId{1}, 0}));
  EXPECT_EQ(options->antennas, (std::vector<std::size_t>{2, 1}));
  EXPECT_EQ(options->limits_m[1], 50.0);
  EXPECT_EQ(options->latency_s, 0.02);
  EXPECT_EQ(options->stamp, drive::RangeStamp::kRecord);
}

TEST(RangeJob, each_vehicle_has_its_antennas_and_those_of_its_peers) {
  const config::FleetConfig fleet =
      fleet_of("ranges: {sigma_m: 0.3, limits_m: [1, 50], bias_m: {v2-v1: 0.12}}\n");
  const vehicle::VehicleSettings v1 = settings_of(fleet, 0), v2 = settings_of(fleet, 1);
  EXPECT_EQ(v1.antennas_body_m.at(1).x(), -1.0);
  ASSERT_EQ(v1.peers.size(), 1U);
  EXPECT_EQ(v1.peers[0].id, VehicleId{1});
  EXPECT_EQ(v1.peers[0].name, "v2");
  EXPECT_EQ(v2.peers.at(0).antennas_body_m.size(), 2U);
  EXPECT_EQ(v1.peers[0].bias_m, 0.12);
  EXPECT_EQ(v2.peers[0].bias_m, 0.12) << "a pair is one whichever way it is written";
  EXPECT_EQ(v1.ranging.limits.sigma_m, 0.3);
  EXPECT_EQ(v1.ranging.limits.near_m, 1.0);
  EXPECT_EQ(v1.ranging.limits.far_m, 50.0);
  EXPECT_FALSE(settings_of(fleet_of(""), 0).peers[0].bias_m) << "estimated";
}

TEST(RangeJob, a_start_pose_prior_applies_to_both_of_its_vehicles) {
  const config::FleetConfig fleet = fleet_of(
      "priors: [{vehicle: v2, relative_to: v1, xyz_m: [3, 0, 0], yaw_deg: 90, sigma_m: 0.3,\n"
      "          sigma_deg: 5.729578}]\n");  // 0.1 rad
  const auto prior_1 = settings_of(fleet, 0).peers.at(0).prior;
  const auto prior_2 = settings_of(fleet, 1).peers.at(0).prior;
  ASSERT_TRUE(prior_1 && prior_2);
  EXPECT_TRUE(prior_1->T_self_peer.p.isApprox(geometry::Vec3(3.0, 0.0, 0.0)));
  // v2 faces left as seen from v1: v1 is 3 m to the left of v2 (its +y).
  EXPECT_TRUE(prior_2->T_self_peer.p.isApprox(geometry::Vec3(0.0, 3.0, 0.0), 1e-9))
      << prior_2->T_self_peer.p.transpose();
  EXPECT_NEAR(prior_1->sigma_m, 0.3, 1e-12);
  EXPECT_NEAR(prior_2->sigma_m, 0.3, 1e-12);
  EXPECT_NEAR(prior_2->sigma_rad, 0.1, 1e-6) << "swings it about, as from the other end";
  EXPECT_FALSE(settings_of(fleet_of(""), 0).peers[0].prior);
}

TEST(RangeJob, priors_relative_to_a_third_vehicle_are_combined) {
  const config::FleetConfig fleet = fleet_of(
      "  v3: {recording: c}\n"
      "priors: [{vehicle: v2, relative_to: v1, xyz_m: [-2, 0, 0], sigma_m: 0.3},\n"
      "         {vehicle: v3, relative_to: v1, xyz_m: [-4, 0.5, 0], sigma_m: 0.4}]\n");
  const auto peers = settings_of(fleet, 1).peers;
  ASSERT_EQ(peers.size(), 2U);
  ASSERT_TRUE(peers[1].prior) << "of v3, seen from v2";
  EXPECT_TRUE(peers[1].prior->T_self_peer.p.isApprox(geometry::Vec3(-2.0, 0.5, 0.0), 1e-9));
  EXPECT_NEAR(peers[1].prior->sigma_m, 0.5, 1e-9);
}

TEST(RangeJob, a_vehicle_without_antennas_has_one_at_the_body_origin) {
  const config::FleetConfig fleet =
      config::parse_fleet("vehicles: {v1: {recording: a, antennas: {}}}", "fleet.yaml", "", {})
          .value();
  EXPECT_EQ(settings_of(fleet, 0).antennas_body_m.size(), 1U);
  EXPECT_EQ(range_options(fleet)->antennas, (std::vector<std::size_t>{1}));
}

}  // namespace
}  // namespace rali::jobs
