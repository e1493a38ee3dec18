#pragma once

#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/sensor/range_sample.hpp"
#include "rali/sim/fleet/fleet_motion.hpp"
#include "rali/sim/radio/radio_model.hpp"
#include "rali/sim/simulation.hpp"

namespace rali::sim {

/// Several vehicles in one world. Same options and world: same bytes. The first vehicles of a fleet
/// have the same sensor noise as those of a smaller fleet.
struct FleetOptions {
  SimOptions
      vehicle;  ///< common to all; `scene` is ignored, standstill_s = 0 too (all start still)
  int vehicles = 1;
  bool scripted = true;  ///< drives world.rounds; false: all stay still until motion() moves them
  double pause_s = 4.0;  ///< standstill between rounds
  int antennas = 1;      ///< of each vehicle, 1 or 2
  double antenna_error_m = 0.01;  ///< of the nominal lever arms, random direction
  bool ranges = true;
  bool radio_link = true;
  UwbOptions uwb;
  RadioOptions radio;

  template <class V>
  void visit(V& v) {
    v("pause_s", pause_s, 0.0, 600.0, "standing time between rounds");
    v("antenna_error_m", antenna_error_m, 0.0, 1.0, "error of the nominal lever arms");
    v("ranges", ranges, "the vehicles measure ranges to each other");
    v("radio_link", radio_link, "the vehicles measure the strength of their data link");
    v.group("uwb", uwb, "errors of the ranges");
    v.group("radio", radio, "data link");
  }
};

/// A message of one vehicle's recording.
struct FleetMessage {
  int vehicle = 0;  ///< that measured; ranges and radio readings: `from` and `to`, respectively
  std::variant<sensor::ImuSample, std::shared_ptr<const sensor::LidarScan>, sensor::RangeSample,
               sensor::RadioSample>
      data;
};

/// Position of an antenna in the body frame.
struct AntennaMount {
  geometry::Vec3 p_true_m = geometry::Vec3::Zero();
  geometry::Vec3 p_nominal_m = geometry::Vec3::Zero();  ///< as a user would measure it
};

/// Current biases of a vehicle's inertial sensor.
struct ImuBias {
  geometry::Vec3 gyro_radps = geometry::Vec3::Zero();
  geometry::Vec3 accel_mps2 = geometry::Vec3::Zero();
};

/// Generates the recordings of a fleet in a world, message by message. The sensors of different
/// vehicles are not synchronised: each vehicle but the first has its own clock phase.
class FleetSimulation {
 public:
  ~FleetSimulation();
  FleetSimulation(const FleetSimulation&) = delete;
  FleetSimulation& operator=(const FleetSimulation&) = delete;

  /// The next message of all vehicles in the order of arrival. Empty at the end, or, if not
  /// scripted, when messages have reached the end of the driven trajectories.
  [[nodiscard]] std::optional<FleetMessage> next();

  /// Casts scans with this executor from now on; results do not depend on it. It must outlive this.
  void use(Executor& executor);

  /// The raw scan of the last LidarScan of next().
  [[nodiscard]] const RawScan& last_raw_scan() const;
  /// Ground truth of the last RangeSample of next().
  [[nodiscard]] const RangeTruth& last_range_truth() const;

  /// Exact motion; t is clamped to the driven trajectory.
  [[nodiscard]] Truth truth(int vehicle, Time t) const;
  [[nodiscard]] Time t_start() const;
  /// Scripted: the end of the simulation. Otherwise: the end of the driven trajectories.
  [[nodiscard]] Time t_end() const;
  [[nodiscard]] int vehicles() const;
  [[nodiscard]] bool scripted() const;
  [[nodiscard]] double path_m(int vehicle) const;

  [[nodiscard]] const sensor::Calibration& calibration_true(int vehicle) const;
  [[nodiscard]] const sensor::Calibration& calibration_nominal(int vehicle) const;
  [[nodiscard]] const std::vector<AntennaMount>& antennas(int vehicle) const;
  /// At the vehicle's last inertial sample.
  [[nodiscard]] ImuBias imu_bias(int vehicle) const;
  [[nodiscard]] const LidarModel& lidar_model() const;
  [[nodiscard]] const UwbModel& uwb() const;
  /// For a scripted simulation.
  [[nodiscard]] const std::vector<RoundTimes>& rounds() const;

  [[nodiscard]] const World& world() const;

  [[nodiscard]] const TriangleMesh& mesh() const { return world().mesh; }

  [[nodiscard]] const RayCaster& ray_caster() const;

  /// The radio model, for messages between vehicles.
  [[nodiscard]] RadioModel& radio();

  /// Drives vehicles that are not scripted: step() it, then take messages until next() has none.
  [[nodiscard]] FleetMotion& motion();

 private:
  struct Impl;
  explicit FleetSimulation(std::unique_ptr<Impl> impl);
  friend Result<std::unique_ptr<FleetSimulation>> make_fleet_simulation(World world,
                                                                        const FleetOptions&);

  std::unique_ptr<Impl> impl_;
};

/// @param world  with starts for all vehicles (world_for())
/// Errors (kUsage) name the option, or the round in which vehicles block each other.
[[nodiscard]] Result<std::unique_ptr<FleetSimulation>> make_fleet_simulation(
    World world, const FleetOptions& options);

}  // namespace rali::sim
