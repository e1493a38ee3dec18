#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rali/net/ros_bus.hpp"
#include "rali/scenario/recording/vehicle_recorder.hpp"
#include "rali/sim/fleet/closed_loop.hpp"
#include "rali/wire/goal_status.hpp"
#include "rali/wire/messages.hpp"

namespace rali::host {

struct LiveWorldOptions {
  std::vector<std::string> vehicles;  ///< names by number
  sim::Lidar lidar = sim::Lidar::kRs16;
};

/// Messages received by the world so far.
struct LiveWorldCounts {
  std::uint64_t goals = 0;
  std::uint64_t unreadable = 0;  ///< messages to the world: dropped
};

/// A simulated world with ROS 2 interfaces only, like real robots: each vehicle's sensors are
/// topics under its name, and the simulated drivers take the part of Nav2. A vehicle drives to
/// `/<v>/goal_pose`, located by `/tf` (map to odom) and `/<v>/odom`. It reports the state of the
/// goal in `/<v>/navigate_to_pose/_action/status`.
class LiveWorld final : public sim::FleetSoftware {
 public:
  /// @param wait blocks until the given time of the world is due, however long that takes; false
  /// ends the mission
  /// Errors: those of RosBus.
  [[nodiscard]] static Result<std::unique_ptr<LiveWorld>> make(net::RosBus& bus,
                                                               const LiveWorldOptions& options,
                                                               std::function<bool(Time)> wait);

  void on_message(const sim::FleetMessage& message) override;
  [[nodiscard]] std::vector<sim::DriveCommand> decide(
      Time now, std::span<const sim::DriveReport> vehicles) override;

  [[nodiscard]] bool finished() const override { return stopped_; }

  [[nodiscard]] const LiveWorldCounts& counts() const { return counts_; }

  /// Vehicles whose LiDAR topic has no subscriber yet.
  [[nodiscard]] std::vector<std::string> unsubscribed() const;

 private:
  struct Vehicle {
    std::string name;
    int cloud = 0, imu = 0, ranges = 0, status = 0;  ///< publications
    int goal = 0, odom = 0;                          ///< subscriptions
    std::optional<geometry::SE3> T_map_odom, T_odom_body;
    Time t_pose;
    std::optional<wire::PoseStamped> waiting;  ///< a goal that has not become a command yet
    wire::GoalStatusArray status_sent;         ///< of the last goal
    std::uint64_t goals = 0;                   ///< commands to go so far
  };

  LiveWorld(net::RosBus& bus, const LiveWorldOptions& options, std::function<bool(Time)> wait);

  [[nodiscard]] Status open();
  [[nodiscard]] Status open(Vehicle& vehicle);
  void publish(int publication, const wire::Bytes& bytes);
  void send(const sensor::LidarScan& scan, const Vehicle& vehicle);
  void send(const sensor::RangeSample& range);
  void take(Time now);
  void take_goal(Vehicle& vehicle, const net::RosMessage& message, Time now);
  void take_tf(const net::RosMessage& message);
  void take_odom(Vehicle& vehicle, const net::RosMessage& message);
  void send_status(Vehicle& vehicle, const sim::DriveReport& report);
  [[nodiscard]] std::optional<sim::DriveCommand> command(std::size_t index);

  net::RosBus& bus_;
  LiveWorldOptions options_;
  std::function<bool(Time)> wait_;
  std::vector<Vehicle> vehicles_;
  int tf_ = 0;
  LiveWorldCounts counts_;
  bool stopped_ = false;
};

}  // namespace rali::host
