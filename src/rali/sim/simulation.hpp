#pragma once

#include <memory>
#include <optional>
#include <variant>

#include "rali/base/result.hpp"
#include "rali/sensor/imu_sample.hpp"
#include "rali/sensor/lidar_scan.hpp"
#include "rali/sim/ray_caster.hpp"
#include "rali/sim/sim_options.hpp"

namespace rali::sim {

/// A message of the sensors.
using Message = std::variant<sensor::ImuSample, std::shared_ptr<const sensor::LidarScan>>;

/// True motion at one time.
struct Truth {
  Time t;
  MotionState state;  ///< body, in the world frame
};

/// Generates a recording in a world, message by message.
class Simulation {
 public:
  explicit Simulation(const SimOptions& options);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  /// The next message in the order of arrival (a scan arrives after the inertial sample at or
  /// before its last point), empty at the end.
  [[nodiscard]] std::optional<Message> next();

  /// The raw scan of the last LidarScan of next(): for compact recordings.
  [[nodiscard]] const RawScan& last_raw_scan() const;

  /// Exact motion; t is clamped to the recording.
  [[nodiscard]] Truth truth(Time t) const;
  [[nodiscard]] Time t_start() const;
  [[nodiscard]] Time t_end() const;
  [[nodiscard]] double path_m() const;  ///< length of the whole route

  [[nodiscard]] const sensor::Calibration& calibration_true() const;
  /// As measured by a user: with the options' errors.
  [[nodiscard]] const sensor::Calibration& calibration_nominal() const;

  [[nodiscard]] const World& world() const;

  [[nodiscard]] const TriangleMesh& mesh() const { return world().mesh; }

  [[nodiscard]] const RayCaster& ray_caster() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Checks the options and builds the world. Errors name the option.
[[nodiscard]] Result<std::unique_ptr<Simulation>> make_simulation(const SimOptions& options);

}  // namespace rali::sim
