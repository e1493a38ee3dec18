#pragma once

#include <memory>
#include <vector>

#include "case.hpp"
#include "rali/drive/reported_source.hpp"
#include "rali/eval/association.hpp"
#include "rali/sim/fleet/fleet_simulation.hpp"

namespace rali::campaign {

/// Measurements of one vehicle's sensors in the simulation's compact form.
struct Track {
  std::string name;
  sensor::Calibration calibration;  ///< as known to the user
  std::vector<geometry::Vec3> antennas_m;
  std::vector<sensor::ImuSample> imu;

  struct Scan {
    Time t_start;
    sim::RawScan raw;
  };

  std::vector<Scan> scans;
  eval::PoseList truth;  ///< T_world_body at 50 Hz
  double distance_m = 0.0;
};

/// A case, simulated once and kept in memory: it can be played any number of times.
class Recording {
 public:
  /// Errors: of the world, or vehicles that block each other; such a case is drawn again.
  [[nodiscard]] static Result<std::shared_ptr<const Recording>> make(Case c, const Ranges& ranges);

  [[nodiscard]] const Case& description() const { return case_; }

  [[nodiscard]] const std::vector<Track>& tracks() const { return tracks_; }

  [[nodiscard]] const std::vector<sensor::RangeSample>& ranges() const { return ranges_; }

  [[nodiscard]] const sim::World& world() const { return world_; }

  [[nodiscard]] Time t_start() const { return t_start_; }

  [[nodiscard]] Time t_end() const { return t_end_; }

  /// The events of one vehicle, as a file reader would deliver them.
  [[nodiscard]] static std::unique_ptr<drive::ReportedSource> play(
      std::shared_ptr<const Recording> recording, std::size_t vehicle,
      const drive::InputOptions& options);

  [[nodiscard]] std::shared_ptr<const sensor::LidarScan> scan(const Track::Scan& scan) const;

 private:
  explicit Recording(Case c) : case_(std::move(c)), model_(case_.setup.fleet.vehicle.lidar) {}

  void take(sim::FleetSimulation& sim);
  void begin(const sim::FleetSimulation& sim);
  void add_truth(const sim::FleetSimulation& sim);
  void spoil_ranges();

  Case case_;
  sim::LidarModel model_;
  sim::World world_;
  Time t_start_, t_end_;
  std::vector<Track> tracks_;
  std::vector<sensor::RangeSample> ranges_;
};

}  // namespace rali::campaign
