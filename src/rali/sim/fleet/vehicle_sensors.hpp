#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "rali/sim/sim_options.hpp"
#include "rali/sim/trajectory.hpp"

namespace rali::sim {

/// LiDAR and inertial sensor of one vehicle of a fleet, with its clock phases.
class VehicleSensors {
 public:
  /// @param trajectory  of the vehicle; must outlive this object
  VehicleSensors(const SimOptions& options, int vehicle, const Trajectory& trajectory,
                 MovingScene others);

  /// Arrival time of the next message, in seconds since the start.
  [[nodiscard]] double next_imu_s() const;
  [[nodiscard]] double next_scan_s() const;

  [[nodiscard]] sensor::ImuSample take_imu();
  [[nodiscard]] std::shared_ptr<const sensor::LidarScan> take_scan(const RayCaster& world,
                                                                   Executor& executor);

  [[nodiscard]] const RawScan& raw_scan() const { return lidar_.raw(); }

  [[nodiscard]] const LidarModel& lidar_model() const { return lidar_.model(); }

  [[nodiscard]] const ImuModel& imu() const { return imu_; }

  [[nodiscard]] const sensor::Calibration& calibration_true() const { return true_; }

  [[nodiscard]] const sensor::Calibration& calibration_nominal() const { return nominal_; }

 private:
  SimOptions options_;
  const Trajectory* trajectory_;
  MovingScene others_;
  LidarSensor lidar_;
  ImuModel imu_;
  sensor::Calibration true_, nominal_;
  double imu_phase_s_ = 0.0, scan_phase_s_ = 0.0;
  std::int64_t imu_count_ = 0, scan_count_ = 0;
};

}  // namespace rali::sim
