#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/scenario/faults/fault.hpp"
#include "rali/scenario/recording/vehicle_recorder.hpp"
#include "rali/sim/fleet/fleet_simulation.hpp"

namespace rali::scenario {

struct RecordingOptions {
  std::string folder;
  RecordingFormat format = RecordingFormat::kMcap;
  sim::Lidar lidar = sim::Lidar::kRs16;  ///< the LiDAR of the simulation
  bool with_imu = true;
  std::uint64_t seed = 1;  ///< of the faults and of simulated user measurement errors
  std::vector<Fault> faults;
  bool priors = true;      ///< fleet.yaml contains the start poses of the vehicles
  std::string scene_yaml;  ///< effective scene; empty: no scene.yaml
  std::string title;       ///< of the scene, for simulation.json
};

/// Contents of one vehicle's recording.
struct VehicleSummary {
  std::string name, file;
  std::uint64_t scans = 0, points = 0, imu_samples = 0;
  std::uint64_t lost = 0;  ///< messages dropped by faults
  double path_m = 0.0;
  bool cut = false;  ///< the file is truncated
};

struct RecordingSummary {
  std::string title;
  std::uint64_t seed = 0;
  double duration_s = 0.0;
  std::vector<VehicleSummary> vehicles;
  std::uint64_t ranges = 0, ranges_obstructed = 0, ranges_spoilt = 0, radio_readings = 0;
  std::vector<Fault> faults;
  bool interrupted = false;  ///< stopped early, but all files are complete
};

/// Called with the progress, 0 to 1; returning false ends the recording there.
using RecordingProgress = std::function<bool(double fraction)>;

/// Prepares the folder. A non-empty folder is refused unless `overwrite`. Then the files that
/// `rali simulate` writes are removed, but only if simulation.json marks the folder as its own.
/// Errors: kUsage, kMachine.
[[nodiscard]] Status prepare_recording_folder(const std::string& folder, bool overwrite);

/// Runs the simulation to its end and writes it as a user would have recorded it:
/// `<v>.mcap` (or .bag, or a rosbag2 folder), ranges.csv, radio.csv (two vehicles or more),
/// fleet.yaml, scene.yaml, truth/ and simulation.json, which has the counts. Same simulation and
/// options: same bytes. Each file gets its final name when complete. Memory does not grow with the
/// duration.
/// Errors: kMachine (disk).
[[nodiscard]] Result<RecordingSummary> write_recording(sim::FleetSimulation& sim,
                                                       const RecordingOptions& options,
                                                       const RecordingProgress& progress);

/// Drives a simulation and passes every message to `tap`, in order. An error of `tap` ends it and
/// is returned. @return true if it was interrupted: the recording is complete up to there
using RecordingDrive =
    std::function<Result<bool>(const std::function<Status(const sim::FleetMessage&)>& tap)>;

/// The same for an unscripted simulation, which `drive` runs. Errors: those of `drive` too.
[[nodiscard]] Result<RecordingSummary> record_drive(sim::FleetSimulation& sim,
                                                    const RecordingOptions& options,
                                                    const RecordingDrive& drive);

/// Contents of simulation.json, and output of `rali simulate --json`.
[[nodiscard]] std::string summary_json(const RecordingSummary& summary);

}  // namespace rali::scenario
