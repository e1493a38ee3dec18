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

/// What the odometry's thread tells the agent's.
struct VehicleNews {
  vehicle::Output output;
};

struct RangeNews {
  sensor::RangeSample sample;
};

/// What the navigation says of its goals.
struct GoalNews {
  wire::GoalStatusArray status;
};

/// How the sensors do, once a second.
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

/// The first event has come: what its stamp says against the arrival on this machine's clock.
struct ClockNews {
  Duration ahead;  ///< stamp less arrival
};

using ToAgent = std::variant<VehicleNews, RangeNews, GoalNews, SensorNews, ClockNews>;

/// What the agent's thread tells the odometry's.
struct FrameNews {
  std::optional<geometry::SE3> T_map_local;
};

using ToSensors = std::variant<fleet::PeerStatus, FrameNews>;

/// Takes a message that is to leave at once.
using Publish = std::function<void(const RosOut&)>;

struct SensorSideSetup {
  IntakeSetup intake;
  vehicle::VehicleSettings vehicle;
  VehicleId self;
};

/// The sensors and the odometry of one vehicle: messages in, poses out. What its thread runs,
/// without the thread.
class SensorSide {
 public:
  SensorSide(SensorSideSetup setup, Executor& executor);

  [[nodiscard]] SensorIntake& intake() { return intake_; }

  void take(const ToSensors& news);

  /// Runs what may leave the intake. @param now on the clock of arrivals, which may be asked again:
  /// the latency of a pose is from its scan's arrival to the return of the step
  void run(const std::function<Time()>& now, const Publish& publish, std::vector<ToAgent>& news);

  /// No more data will come: what waits is finished.
  void finish(const Publish& publish, std::vector<ToAgent>& news);

  /// T_map_body of the poses that the last run() or finish() has published; of those alone that are
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
  std::optional<Time> scan_arrival_;  ///< of the last scan that the vehicle was handed
  Time t_started_;                    ///< of the odometry: what came before waited for decisions
  std::uint64_t scans_ = 0;
};

}  // namespace rali::host
