#include "rali/sim/fleet/vehicle_sensors.hpp"

#include "rali/sim/fleet/fleet_motion.hpp"

namespace rali::sim {

VehicleSensors::VehicleSensors(const SimOptions& options, int vehicle, const Trajectory& trajectory,
                               MovingScene others)
    : options_(options),
      trajectory_(&trajectory),
      others_(std::move(others)),
      lidar_(options.lidar, options.ranging, vehicle_seed(options.seed, vehicle)),
      imu_(options.imu, vehicle_seed(options.seed, vehicle)),
      true_(sensor_mounting(options.imu_apart)),
      nominal_(measured_by_hand(true_, options, vehicle_seed(options.seed, vehicle))) {
  if (vehicle == 0) return;
  Rng rng(vehicle_seed(options.seed, vehicle), "phase");
  imu_phase_s_ = rng.uniform(0.0, 1.0 / options.imu.rate_hz);
  scan_phase_s_ = rng.uniform(0.0, lidar_.model().scan_s());
}

double VehicleSensors::next_imu_s() const {
  return imu_phase_s_ + static_cast<double>(imu_count_) / options_.imu.rate_hz;
}

double VehicleSensors::next_scan_s() const {
  return scan_phase_s_ + static_cast<double>(scan_count_ + 1) * lidar_.model().scan_s();
}

sensor::ImuSample VehicleSensors::take_imu() {
  const double t_s = next_imu_s();
  ++imu_count_;
  MotionState state = trajectory_->at(t_s);
  state.a_world_mps2 += trajectory_->measured_jolt_mps2(t_s, 1.0 / options_.imu.rate_hz);
  const Time t = options_.start + Duration::from_s(t_s);
  return imu_.measure(ideal_imu(t, state, true_.T_body_imu), state.v_world_mps.norm());
}

std::shared_ptr<const sensor::LidarScan> VehicleSensors::take_scan(const RayCaster& world,
                                                                   Executor& executor) {
  const auto pose_at = [this](double t_s) {
    return trajectory_->pose_at(t_s) * true_.T_body_lidar;
  };
  const double start_s = next_scan_s() - lidar_.model().scan_s();
  const RawScan& raw =
      lidar_.measure_scan(scan_count_++, start_s, pose_at, world, others_, executor);
  return expand(raw, lidar_.model(), options_.ranging.resolution_m,
                options_.start + Duration::from_s(start_s));
}

}  // namespace rali::sim
