#include "rali/sim/simulation.hpp"

#include "rali/base/assert.hpp"

namespace rali::sim {

struct Simulation::Impl {
  explicit Impl(const SimOptions& o)
      : options(o),
        world(make_world(o.scene, o.seed)),
        caster(world.mesh),
        route(world.route, world.rounding_m),
        trajectory(make_trajectory(route, o.motion, o.seed)),
        people(Pedestrians(route, crowd_of(o), world.free_width_m, o.seed)),
        lidar(o.lidar, o.ranging, o.seed),
        imu(o.imu, o.seed),
        calibration_true(sensor_mounting(o.imu_apart)),
        calibration_nominal(measured_by_hand(calibration_true, o, o.seed)),
        duration_s(o.duration_s > 0.0 ? o.duration_s : trajectory.duration_s()) {}

  [[nodiscard]] double imu_time_s() const {
    return static_cast<double>(imu_count) / options.imu.rate_hz;
  }

  sensor::ImuSample next_imu() {
    const double t_s = imu_time_s();
    ++imu_count;
    MotionState state = trajectory.at(t_s);
    state.a_world_mps2 += trajectory.measured_jolt_mps2(t_s, 1.0 / options.imu.rate_hz);
    const Time t = options.start + Duration::from_s(t_s);
    return imu.measure(ideal_imu(t, state, calibration_true.T_body_imu), state.v_world_mps.norm());
  }

  std::shared_ptr<const sensor::LidarScan> next_scan() {
    const auto pose_at = [this](double t_s) {
      return trajectory.pose_at(t_s) * calibration_true.T_body_lidar;
    };
    const double t_s = static_cast<double>(scan_count) * lidar.model().scan_s();
    raw = &lidar.measure_scan(scan_count++, t_s, pose_at, caster, people, serial);
    return expand(*raw, lidar.model(), options.ranging.resolution_m,
                  options.start + Duration::from_s(t_s));
  }

  SimOptions options;
  World world;
  RayCaster caster;
  Route route;
  Trajectory trajectory;
  MovingScene people;
  SerialExecutor serial;
  LidarSensor lidar;
  ImuModel imu;
  sensor::Calibration calibration_true, calibration_nominal;
  double duration_s;
  std::int64_t imu_count = 0;
  std::int64_t scan_count = 0;
  const RawScan* raw = nullptr;  ///< in `lidar`
};

Simulation::Simulation(const SimOptions& options) : impl_(std::make_unique<Impl>(options)) {}

Simulation::~Simulation() = default;

std::optional<Message> Simulation::next() {
  Impl& s = *impl_;
  const double scan_s = s.lidar.model().scan_s();
  const double scan_end_s = static_cast<double>(s.scan_count + 1) * scan_s;
  const bool scan_left = s.options.with_lidar && scan_end_s <= s.duration_s + 1e-9;
  // The sample at the very end of a scan comes after it.
  const bool imu_left = s.options.with_imu && s.imu_time_s() <= s.duration_s + 1e-9;
  if (imu_left && (!scan_left || s.imu_time_s() < scan_end_s - 1e-9)) return s.next_imu();
  if (scan_left) return s.next_scan();
  return std::nullopt;
}

const RawScan& Simulation::last_raw_scan() const {
  RALI_ASSERT(impl_->raw != nullptr);
  return *impl_->raw;
}

Truth Simulation::truth(Time t) const {
  return {t, impl_->trajectory.at(seconds_between(impl_->options.start, t))};
}

Time Simulation::t_start() const { return impl_->options.start; }

Time Simulation::t_end() const {
  return impl_->options.start + Duration::from_s(impl_->duration_s);
}

double Simulation::path_m() const { return impl_->trajectory.length_m(); }

const sensor::Calibration& Simulation::calibration_true() const { return impl_->calibration_true; }

const sensor::Calibration& Simulation::calibration_nominal() const {
  return impl_->calibration_nominal;
}

const World& Simulation::world() const { return impl_->world; }

const RayCaster& Simulation::ray_caster() const { return impl_->caster; }

Result<std::unique_ptr<Simulation>> make_simulation(const SimOptions& options) {
  if (const Status checked = check_options(options); !checked) {
    return tl::make_unexpected(checked.error());
  }
  return std::make_unique<Simulation>(options);
}

}  // namespace rali::sim
