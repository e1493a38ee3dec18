#pragma once

#include <memory>
#include <vector>

#include "case.hpp"
#include "rali/drive/reported_source.hpp"
#include "rali/eval/association.hpp"
#include "rali/sim/fleet/fleet_simulation.hpp"

namespace rali::campaign {

/// What one vehicle's sensors measured, in the little space in which the simulation has it.
struct Track {
  std::string name;
  sensor::Calibration calibration;  ///< as the user knows it
  std::vector<geometry::Vec3> antennas_m;
  std::vector<sensor::ImuSample> imu;

  struct Sweep {
    Time t_begin;
    sim::RawSweep raw;
  };

  std::vector<Sweep> sweeps;
  eval::PoseList truth;  ///< T_world_body at 50 Hz
  double distance_m = 0.0;
};

/// A case, simulated once and kept in memory: it can be played as often as the mapping asks.
class Recording {
 public:
  /// Errors: of the place, or vehicles in each other's way; such a case is drawn anew.
  [[nodiscard]] static Result<std::shared_ptr<const Recording>> make(Case c, const Ranges& ranges);

  [[nodiscard]] const Case& description() const { return case_; }

  [[nodiscard]] const std::vector<Track>& tracks() const { return tracks_; }

  [[nodiscard]] const std::vector<sensor::RangeSample>& ranges() const { return ranges_; }

  [[nodiscard]] const sim::World& world() const { return world_; }

  [[nodiscard]] Time t_begin() const { return t_begin_; }

  [[nodiscard]] Time t_end() const { return t_end_; }

  /// The events of one vehicle, as a reader of files would hand them out.
  [[nodiscard]] static std::unique_ptr<drive::ReportedSource> play(
      std::shared_ptr<const Recording> recording, std::size_t vehicle,
      const drive::InputOptions& options);

  [[nodiscard]] std::shared_ptr<const sensor::LidarScan> scan(const Track::Sweep& sweep) const;

 private:
  explicit Recording(Case c) : case_(std::move(c)), model_(case_.setup.fleet.vehicle.lidar) {}

  void take(sim::FleetSimulation& sim);
  void begin(const sim::FleetSimulation& sim);
  void add_truth(const sim::FleetSimulation& sim);
  void spoil_ranges();

  Case case_;
  sim::LidarModel model_;
  sim::World world_;
  Time t_begin_, t_end_;
  std::vector<Track> tracks_;
  std::vector<sensor::RangeSample> ranges_;
};

}  // namespace rali::campaign
