#include <algorithm>
#include <memory>

#include <gtest/gtest.h>

#include "rali/odometry/room_for_test.hpp"
#include "rali/vehicle/vehicle.hpp"

// odom of a whole vehicle: whatever happens to the estimate, it never jumps (REP-105).

namespace rali::vehicle {
namespace {

using odometry::TestRoom;
using sensor::LidarScan;

struct Steps {
  double odom_max_m = 0.0;   ///< from one scan to the next, beyond the speed known before
  double local_max_m = 0.0;  ///< from one scan to the next
  bool lost = false;
};

/// Drives; from `covered_s` on the LiDAR gives no points for 2.5 s.
Steps drive(TestRoom room, bool has_imu, double covered_s, double until_s) {
  VehicleSettings settings;
  settings.calibration.T_body_lidar = room.T_body_lidar;
  settings.has_imu = has_imu;
  Vehicle vehicle(VehicleId{0}, settings);
  SerialExecutor executor;
  Steps steps;
  std::optional<PoseEstimate> last;
  double imu_s = 0.0;
  const auto feed = [&](const Event& event) {
    OutputList out;
    vehicle.step(event, executor, out);
    for (const Output& output : out) {
      if (const auto* f = std::get_if<Finding>(&output)) {
        steps.lost |= f->id == "odometry.diverged";
      }
      const auto* pose = std::get_if<PoseEstimate>(&output);
      if (pose == nullptr) continue;
      if (last) {
        const auto step = [](const geometry::SE3& a, const geometry::SE3& b) {
          return (a.p - b.p).norm();
        };
        const double known_m = TestRoom::kScan_s * last->v_odom_mps.norm();
        steps.odom_max_m =
            std::max(steps.odom_max_m, step(last->T_odom_body, pose->T_odom_body) - known_m);
        steps.local_max_m =
            std::max(steps.local_max_m, step(last->T_local_body, pose->T_local_body));
      }
      last = *pose;
    }
  };
  for (double t_s = 0.0; t_s < until_s - 1e-9; t_s += TestRoom::kScan_s) {
    auto scan = room.scan(t_s);
    for (; has_imu && imu_s <= t_s + TestRoom::kScan_s; imu_s += 0.005) feed(room.imu(imu_s));
    if (t_s > covered_s && t_s < covered_s + 2.5) {
      auto empty = std::make_shared<LidarScan>();
      empty->t_start = scan->t_start;
      empty->t_end = scan->t_end;
      scan = empty;
    }
    feed(std::shared_ptr<const LidarScan>(scan));
  }
  feed(EndOfData{});
  return steps;
}

TestRoom small_room() {
  TestRoom room;
  room.rings = 8;
  room.columns = 150;
  return room;
}

// 3 cm of correction by the LiDAR, and what 1 m/s2 adds to the speed known before.
constexpr double kMotion_m = 0.03 + 0.015;

TEST(OdomOfAVehicle, stays_continuous_when_a_lost_map_restarts) {
  for (const bool has_imu : {false, true}) {
    const Steps steps = drive(small_room(), has_imu, 4.0, 9.0);
    EXPECT_TRUE(steps.lost) << has_imu;
    EXPECT_GT(steps.local_max_m, 0.5) << has_imu << ": the pose goes back to before the loss";
    EXPECT_LT(steps.odom_max_m, kMotion_m) << has_imu;
  }
}

TEST(OdomOfAVehicle, stays_continuous_when_a_start_in_motion_is_reprocessed) {
  TestRoom room = small_room();
  room.rest_s = -3.0;
  for (const bool has_imu : {false, true}) {
    EXPECT_LT(drive(room, has_imu, 1e9, 4.0).odom_max_m, kMotion_m) << has_imu;
  }
}

}  // namespace
}  // namespace rali::vehicle
