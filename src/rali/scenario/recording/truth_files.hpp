#pragma once

#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/io/files/csv_writer.hpp"
#include "rali/io/files/tum.hpp"
#include "rali/sim/fleet/fleet_simulation.hpp"

namespace rali::scenario {

/// Writes the folder truth/ of a fleet recording during the simulation: `<v>.tum` (T_world_body at
/// 100 Hz), `ranges.csv` (ground truth of the exchanges in ranges.csv), `biases.csv` (of the
/// inertial sensors once a second, of the pairs of antennas once), `mesh.ply`.
class TruthFiles {
 public:
  /// @param folder  must exist
  /// @param names   of the vehicles
  [[nodiscard]] static Result<TruthFiles> create(const std::string& folder,
                                                 const std::vector<std::string>& names,
                                                 const sim::FleetSimulation& sim);

  /// Writes poses and biases up to time t.
  [[nodiscard]] Status reach(Time t, const sim::FleetSimulation& sim);

  [[nodiscard]] Status add(const sensor::RangeSample& range, const sim::RangeTruth& truth);

  /// Distance driven by vehicle `v` until the last pose [m].
  [[nodiscard]] double path_m(std::size_t v) const { return path_m_[v]; }

  /// Writes poses up to `until`; then all files get their final names.
  [[nodiscard]] Status finish(Time until, const sim::FleetSimulation& sim);

 private:
  TruthFiles(std::string folder, std::vector<std::string> names)
      : folder_(std::move(folder)), names_(std::move(names)) {}

  [[nodiscard]] Status open(const sim::FleetSimulation& sim);
  [[nodiscard]] Status add_pair_biases(const sim::FleetSimulation& sim);
  [[nodiscard]] Status add_imu_biases(Time t, const sim::FleetSimulation& sim);
  [[nodiscard]] Status add_bias(Time t, const std::string& of, const char* quantity, double value);

  std::string folder_;
  std::vector<std::string> names_;
  std::vector<io::TumWriter> poses_;
  std::vector<io::CsvWriter> tables_;  ///< biases, then ranges of a fleet of two or more
  std::vector<double> path_m_;
  std::vector<geometry::Vec3> last_;
  Time next_pose_, next_bias_;
};

}  // namespace rali::scenario
