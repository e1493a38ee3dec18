#include "rali/drive/closed_loop/fleet_software.hpp"

#include <gtest/gtest.h>

#include "rali/fleet/facts/keyframe_number.hpp"
#include "rali/odometry/room_for_test.hpp"

namespace rali::drive {
namespace {

/// Two vehicles without inertial sensors; the first one scans a room.
struct Scanning {
  Scanning() : fleet(setup(), Time::from_s(0.0), executor) {
    room.rings = 8;
    room.columns = 200;
  }

  static ClosedLoopSetup setup() {
    ClosedLoopSetup setup;
    setup.fleet.names = {"v1", "v2"};
    setup.fleet.logs = true;
    setup.vehicles.resize(2);
    for (vehicle::VehicleSettings& settings : setup.vehicles) settings.has_imu = false;
    return setup;
  }

  void scan(double from_s, double to_s) {
    for (double t_s = from_s; t_s < to_s - 1e-9; t_s += 0.1) {
      std::shared_ptr<const sensor::LidarScan> seen = room.scan(t_s);
      fleet.on_message({0, seen});
      static_cast<void>(fleet.decide(Time::from_s(t_s + 0.2), {}));
    }
  }

  [[nodiscard]] std::vector<std::uint32_t> keyframes(std::uint32_t epoch) const {
    std::vector<std::uint32_t> numbers;
    fleet.nodes().node(0).store().for_each(
        {VehicleId{0}, epoch}, 0, 1000, [&](const fleet::FactPtr& fact) {
          const auto* points = std::get_if<fleet::KeyframePoints>(&fact->body);
          if (points) numbers.push_back(points->keyframe);
          return true;
        });
    return numbers;
  }

  SerialExecutor executor;
  odometry::TestRoom room;
  ClosedLoopFleet fleet;
};

TEST(ClosedLoopFleet, a_restarted_vehicle_keeps_its_keyframes_and_continues_in_a_new_epoch) {
  Scanning s;
  s.scan(0.0, 2.0);
  EXPECT_EQ(s.keyframes(0), std::vector<std::uint32_t>{0});
  s.fleet.nodes().kill(0);
  s.scan(2.0, 3.0);
  ASSERT_TRUE(s.fleet.restart(0).has_value());
  EXPECT_EQ(s.keyframes(0), std::vector<std::uint32_t>{0}) << "from its log";
  EXPECT_TRUE(s.keyframes(1).empty());
  s.scan(3.0, 4.0);
  const std::vector<std::uint32_t> later = s.keyframes(1);
  ASSERT_FALSE(later.empty());
  EXPECT_EQ(later.front(), fleet::first_keyframe_of(1));
  EXPECT_EQ(fleet::epoch_of_keyframe(later.back()), 1U);
  EXPECT_EQ(s.keyframes(0), std::vector<std::uint32_t>{0});
  EXPECT_FALSE(s.fleet.restart(0).has_value()) << "it is alive";
}

}  // namespace
}  // namespace rali::drive
