#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/host/duration_stats.hpp"
#include "rali/host/ros_outputs.hpp"
#include "rali/host/sensor_intake.hpp"
#include "rali/io/files/tum.hpp"
#include "rali/vehicle/vehicle.hpp"
#include "rali/wire/goal_status.hpp"

namespace rali::host {

/// Messages from the odometry's thread to the agent's.
struct VehicleNews {
  vehicle::Output output;
};

struct RangeNews {
  sensor::RangeSample sample;
};

/// Goal status from the navigation.
struct GoalNews {
  wire::GoalStatusArray status;
};

/// State of the sensors, once a second.
struct SensorNews {
  bool decided = false;
  std::string waits_for;
  std::vector<SensorHealth> sensors;
  LiveOrderTally order;
  drive::InputGaps gaps;
  double latency_p50_s = 0.0, latency_p99_s = 0.0, latency_max_s = 0.0;
  double scan_step_p50_s = 0.0, scan_step_p99_s = 0.0;
  std::uint64_t scans = 0;  ///< with a pose
};

/// The first event has arrived: the difference between its stamp and its arrival on this machine's
/// clock.
struct ClockNews {
  Duration ahead;  ///< stamp minus arrival
};

using ToAgent = std::variant<VehicleNews, RangeNews, GoalNews, SensorNews, ClockNews>;

/// Messages from the agent's thread to the odometry's.
struct FrameNews {
  std::optional<geometry::SE3> T_map_local;
};

using ToSensors = std::variant<fleet::PeerStatus, FrameNews>;

/// Takes a message that must be sent at once.
using Publish = std::function<void(const RosOut&)>;

struct SensorSideSetup {
  IntakeSetup intake;
  vehicle::VehicleSettings vehicle;
  VehicleId self;
};

/// The sensors and the odometry of one vehicle: messages in, poses out. The work of its thread,
/// without the thread.
class SensorSide {
 public:
  SensorSide(SensorSideSetup setup, Executor& executor);

  [[nodiscard]] SensorIntake& intake() { return intake_; }

  void take(const ToSensors& news);

  /// Processes the due events of the intake. @param now clock of arrivals, read again after each
  /// step: the latency of a pose is from its scan's arrival to the return of the step
  void run(const std::function<Time()>& now, const Publish& publish, std::vector<ToAgent>& news);

  /// No more data will come: waiting events are processed.
  void finish(const Publish& publish, std::vector<ToAgent>& news);

  /// T_map_body of the poses that the last run() or finish() published; only of those that are
  /// placed in the map.
  [[nodiscard]] const std::vector<io::StampedPose>& map_poses() const { return map_poses_; }

  [[nodiscard]] SensorNews sensor_news() const;

 private:
  void start_vehicle(const LiveEvent& first, const Publish& publish, std::vector<ToAgent>& news);
  void step(const vehicle::Event& event, const Publish& publish, std::vector<ToAgent>& news);

  SensorSideSetup setup_;
  Executor& executor_;
  SensorIntake intake_;
  RosOutputs outputs_;
  std::unique_ptr<vehicle::Vehicle> vehicle_;
  vehicle::OutputList step_out_;
  std::vector<LiveEvent> events_;
  std::vector<RosOut> messages_;
  std::vector<io::StampedPose> map_poses_;
  std::optional<geometry::SE3> T_map_local_;
  DurationStats latency_, scan_step_;
  std::optional<Time> scan_arrival_;  ///< of the last scan that the vehicle received
  Time t_started_;                    ///< of the odometry: earlier events waited for decisions
  std::uint64_t scans_ = 0;
};

}  // namespace rali::host
