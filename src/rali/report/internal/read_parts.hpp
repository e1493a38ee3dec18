#pragma once

#include <string>

#include "rali/base/time.hpp"
#include "rali/report/run_data.hpp"

namespace rali::report {

/// The parts of an output folder, each read independently. An absent file leaves its part empty; an
/// unreadable one adds a line to RunData::unreadable.

/// metrics.json, status.json, timing.json, evaluation.json.
/// @return start of the run, 0 if metrics.json does not contain it.
[[nodiscard]] Time read_json_files(const std::string& dir, RunData& run);

/// Vehicles with a trajectory that are not in metrics.json: of a run that was killed.
void add_vehicles_of_files(const std::string& dir, RunData& run);

/// trajectory/, odometry/, degeneracy/, errors/ of one vehicle.
/// @param t_start 0: becomes the first stamp found.
void read_vehicle(const std::string& dir, Time& t_start, VehicleView& vehicle, RunData& run);

/// degeneracy/ of one vehicle. Its trajectory and covariances must be read before.
void read_degenerate(const std::string& dir, Time t_start, VehicleView& vehicle, RunData& run);

/// ranges.csv, counted and thinned while read. The vehicles must be read before.
void read_ranges_table(const std::string& dir, Time t_start, RunData& run);

/// Sums the degenerate distance and what constrained it; received ranges must be read before.
void sum_degenerate_path(VehicleView& vehicle);

/// rounds.csv, frontiers.csv, loops.csv.
void read_fleet_tables(const std::string& dir, Time t_start, RunData& run);

/// map.pcd, else map.ply.
void read_map(const std::string& dir, RunData& run);

/// Marks the vehicles whose frame differs from that of the map.
void find_frame_of_map(RunData& run);

/// Lines of settings.yaml whose origin is not "default".
void read_settings(const std::string& dir, RunData& run);

/// The lines of a settings.yaml as text. Format as of config::dump_fleet: two blanks per level, the
/// origin as a comment after the value.
[[nodiscard]] std::vector<SettingLine> settings_other_than_default(const std::string& text);

[[nodiscard]] bool file_exists(const std::string& path);

}  // namespace rali::report
