#include "rali/vehicle.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "rali/api/convert.hpp"
#include "rali/odometry/room_for_test.hpp"
#include "rali/vehicle/vehicle.hpp"

namespace rali::api {
namespace {

odometry::TestRoom small_room() {
  odometry::TestRoom room;
  room.rings = 8;
  room.columns = 200;
  return room;
}

VehicleOptions options_of(const odometry::TestRoom& room) {
  VehicleOptions options;
  options.name = "scout";
  options.T_body_lidar = public_pose(room.T_body_lidar);
  options.has_imu = false;
  options.peers = {{"beacon", {Vec3::Zero()}}};
  return options;
}

template <class T>
std::vector<T> all_of(const std::vector<Output>& outputs) {
  std::vector<T> found;
  for (const Output& output : outputs) {
    if (const T* value = std::get_if<T>(&output)) found.push_back(*value);
  }
  return found;
}

TEST(PublicVehicle, estimates_the_same_poses_as_the_inner_vehicle) {
  odometry::TestRoom room = small_room();
  const VehicleOptions options = options_of(room);
  Vehicle vehicle(options);
  vehicle::VehicleSettings settings;
  settings.name = options.name;
  settings.calibration.T_body_lidar = room.T_body_lidar;
  settings.has_imu = false;
  settings.peers.push_back({VehicleId{1}, "beacon", {Vec3::Zero()}, {}, {}});
  vehicle::Vehicle inner(VehicleId{0}, settings);
  SerialExecutor executor;
  for (int k = 0; k < 5; ++k) {
    const std::shared_ptr<const sensor::LidarScan> scan = room.scan(0.1 * k);
    const auto poses = all_of<PoseEstimate>(vehicle.step(public_scan(*scan)));
    vehicle::OutputList expected;
    inner.step(scan, executor, expected);
    ASSERT_EQ(poses.size(), 1U);
    EXPECT_EQ(poses[0].vehicle, "scout");
    EXPECT_EQ(poses[0].stamp_ns, scan->t_end.ns);
    for (const auto& output : expected) {
      const auto* pose = std::get_if<vehicle::PoseEstimate>(&output);
      if (pose == nullptr) continue;
      EXPECT_EQ(Vec3(poses[0].T_odom_body.translation()), pose->T_odom_body.p);
      EXPECT_EQ(poses[0].covariance_local(0, 0), pose->covariance(3, 3));
    }
  }
  EXPECT_EQ(vehicle.state_hash(), inner.state_hash());
}

TEST(PublicVehicle, gives_the_first_scan_as_a_keyframe_with_its_points) {
  odometry::TestRoom room = small_room();
  Vehicle vehicle(options_of(room));
  const auto keyframes = all_of<Keyframe>(vehicle.step(public_scan(*room.scan(0.0))));
  ASSERT_EQ(keyframes.size(), 1U);
  EXPECT_GT(keyframes[0].x_m.size(), 500U);
  EXPECT_EQ(keyframes[0].z_m.size(), keyframes[0].x_m.size());
}

TEST(PublicVehicle, drops_and_counts_points_with_nan_range_or_time_errors) {
  odometry::TestRoom room = small_room();
  Scan scan = public_scan(*room.scan(0.0));
  const std::size_t usable = inner_scan(scan, {0.4, 100.0})->size();
  scan.x_m[0] = std::numeric_limits<float>::quiet_NaN();
  scan.x_m[1] = scan.y_m[1] = scan.z_m[1] = 0.0F;
  scan.x_m[2] = 1e6F;
  scan.dt_s[3] = -1.0F;
  const auto inner = inner_scan(scan, {0.4, 100.0});
  ASSERT_TRUE(inner);
  EXPECT_EQ(inner->size(), usable - 4);
  EXPECT_EQ(inner->dropped_nan, 2U);
  EXPECT_EQ(inner->dropped_range, 1U);
  EXPECT_EQ(inner->dropped_time, 1U);
  EXPECT_EQ(inner->ring.size(), inner->size());
}

TEST(PublicVehicle, refuses_arrays_of_different_length_with_a_reason) {
  odometry::TestRoom room = small_room();
  Vehicle vehicle(options_of(room));
  Scan scan = public_scan(*room.scan(0.0));
  scan.intensity.assign(3, 1.0F);
  try {
    (void)vehicle.step(scan);
    FAIL() << "a scan with 3 intensities was taken";
  } catch (const InputError& error) {
    EXPECT_EQ(error.where(), "scan");
    EXPECT_NE(std::string(error.what()).find("intensity has 3 values for"), std::string::npos);
  }
}

TEST(PublicVehicle, evaluates_ranges_to_peers_and_refuses_ranges_to_unknown_vehicles) {
  odometry::TestRoom room = small_room();
  Vehicle vehicle(options_of(room));
  (void)vehicle.step(public_scan(*room.scan(0.0)));
  (void)vehicle.step(PeerState{50'000'000, "beacon", true});
  RangeMeasurement range{150'000'000, "scout", "beacon", 0, 0, 5.0};
  (void)vehicle.step(range);
  const auto results = all_of<RangeResult>(vehicle.step(public_scan(*room.scan(0.1))));
  ASSERT_EQ(results.size(), 1U);
  EXPECT_EQ(results[0].measurement.to, "beacon");
  EXPECT_NE(results[0].reason, "unknown_id");
  range.to = "nobody";
  EXPECT_THROW((void)vehicle.step(range), InputError);
}

TEST(PublicVehicle, refuses_duplicate_vehicle_names) {
  VehicleOptions options;
  options.peers = {{"v2", {Vec3::Zero()}}, {"v2", {Vec3::Zero()}}};
  EXPECT_THROW(Vehicle{options}, SettingsError);
  options.peers = {{"v1", {Vec3::Zero()}}};
  EXPECT_THROW(Vehicle{options}, SettingsError);
}

}  // namespace
}  // namespace rali::api
