#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "rali/config.hpp"
#include "rali/error.hpp"
#include "rali/types.hpp"

namespace rali {

/// The options of `rali map`.
struct MapOptions {
  std::string out = "out";                            ///< folder of the results
  std::vector<std::string> formats = {"pcd", "ply"};  ///< of map.*: pcd, ply, las
  bool overwrite = false;  ///< replace results of an earlier run in `out`
  bool strict = false;     ///< the first gap in the data ends the run
  int threads = 0;         ///< 0: one per core; results do not depend on it
  bool session_mcap = true, keyframe_clouds = true, report = true;
};

/// Progress of a run.
struct MapProgress {
  std::string vehicle;               ///< may be empty
  std::string stage;                 ///< "time offset", "odometry", "fleet", "map", "files"
  double fraction = 0.0;             ///< of the stage, 0 to 1
  double speed = 0.0;                ///< seconds of data per second
  double distance_m = 0.0;           ///< travelled so far
  double degenerate_fraction = 0.0;  ///< of that distance
  std::int64_t stamp_ns = 0;         ///< data time
};

/// Called from the thread that called map_recordings(). An exception from a callback propagates to
/// the caller, after the outputs up to the data time reached are finished.
struct MapCallbacks {
  std::function<bool(const MapProgress&)> progress;  ///< false: stop; may be empty
  std::function<void(const RunFinding&)> finding;    ///< may be empty
};

enum class MapStatus { kComplete, kPartial, kInterrupted };

/// Result of one vehicle. NaN: it has no pose.
struct VehicleSummary {
  std::string name;
  double distance_m = 0.0;
  std::size_t scans = 0, scans_dropped = 0, keyframes = 0;
  double degenerate_fraction = 0.0;                ///< of the distance
  double sigma_median_m = 0.0, sigma_max_m = 0.0;  ///< expected position error, 1 sigma
};

/// Summary of a run; the results themselves are in the folder `out` (docs/reference/outputs.md).
struct MapSummary {
  MapStatus status = MapStatus::kComplete;
  std::string out;
  std::vector<VehicleSummary> vehicles;
  bool connected = true;  ///< all vehicles share one frame
  bool gaps = false;      ///< damaged input or a vehicle without result: exit code 3 of the command
                          ///< line
  std::size_t map_points = 0;
  std::size_t ranges = 0, ranges_used = 0;
  std::size_t loops_closed = 0;
  std::vector<RunFinding> findings;
  std::string metrics_json;  ///< text of metrics.json
};

/// Maps recordings as `rali map` does: same engine, same files. Throws SettingsError (also: `out`
/// has results of an earlier run), InputError, MachineError.
[[nodiscard]] MapSummary map_recordings(const FleetConfig& config, const MapOptions& options = {},
                                        const MapCallbacks& callbacks = {});

}  // namespace rali
