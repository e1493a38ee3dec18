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
  sim::Lidar lidar = sim::Lidar::kRs16;  ///< as the simulation has it
  bool with_imu = true;
  std::uint64_t seed = 1;  ///< of the faults, and of errors of what users measure
  std::vector<Fault> faults;
  bool priors = true;      ///< fleet.yaml says where the vehicles stood at the start
  std::string scene_yaml;  ///< effective scene; empty: no scene.yaml
  std::string title;       ///< of the scene, for simulation.json
};

/// What one vehicle's recording holds.
struct VehicleSummary {
  std::string name, file;
  std::uint64_t sweeps = 0, points = 0, imu_samples = 0;
  std::uint64_t lost = 0;  ///< messages that faults took
  double way_m = 0.0;
  bool cut = false;  ///< the file breaks off
};

struct RecordingSummary {
  std::string title;
  std::uint64_t seed = 0;
  double duration_s = 0.0;
  std::vector<VehicleSummary> vehicles;
  std::uint64_t ranges = 0, ranges_obstructed = 0, ranges_spoilt = 0, radio_readings = 0;
  std::vector<Fault> faults;
  bool interrupted = false;  ///< everything ends before its time, but is whole
};

/// Told how far it is, 0 to 1; false ends the recording there.
using RecordingProgress = std::function<bool(double share)>;

/// Makes the folder ready. One that is not empty is refused, unless `overwrite`: then what
/// `rali simulate` writes is removed, and only if simulation.json says that it made the folder.
/// Errors: kUsage, kMachine.
[[nodiscard]] Status prepare_recording_folder(const std::string& folder, bool overwrite);

/// Runs the simulation to its end and writes it as a user would have recorded it:
/// `<v>.mcap` (or .bag, or a rosbag2 folder), ranges.csv, radio.csv (two vehicles or more),
/// fleet.yaml, scene.yaml, truth/ and simulation.json, which tells the counts. Same simulation and
/// options: same bytes. Each file appears when it is whole. Memory does not grow with the duration.
/// Errors: kMachine (disk).
[[nodiscard]] Result<RecordingSummary> write_recording(sim::FleetSimulation& sim,
                                                       const RecordingOptions& options,
                                                       const RecordingProgress& progress);

/// Drives a simulation and shows every message to `tap`, in order. A tap that fails ends it with
/// its error. @return true if it was interrupted: the recording is whole up to there
using RecordingDrive =
    std::function<Result<bool>(const std::function<Status(const sim::FleetMessage&)>& tap)>;

/// The same of a simulation that follows no script: `drive` runs it. Errors: those of `drive` too.
[[nodiscard]] Result<RecordingSummary> record_drive(sim::FleetSimulation& sim,
                                                    const RecordingOptions& options,
                                                    const RecordingDrive& drive);

/// simulation.json, and what `rali simulate --json` prints.
[[nodiscard]] std::string summary_json(const RecordingSummary& summary);

}  // namespace rali::scenario
