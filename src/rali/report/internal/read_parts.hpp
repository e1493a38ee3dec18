#pragma once

#include <string>

#include "rali/base/time.hpp"
#include "rali/report/run_data.hpp"

namespace rali::report {

/// The parts of an output folder, each read by itself. A file that is absent leaves its part empty;
/// one that cannot be read adds a line to RunData::unreadable.

/// metrics.json, status.json, timing.json, evaluation.json.
/// @return begin of the run, 0 if metrics.json does not say.
[[nodiscard]] Time read_json_files(const std::string& dir, RunData& run);

/// Vehicles that have a trajectory and do not stand in metrics.json: of a run that was killed.
void add_vehicles_of_files(const std::string& dir, RunData& run);

/// trajectory/, odometry/, degeneracy/, errors/ of one vehicle.
/// @param t_begin 0: becomes the first stamp that is met.
void read_vehicle(const std::string& dir, Time& t_begin, VehicleView& vehicle, RunData& run);

/// degeneracy/ of one vehicle: where it was blind. Its way and covariances are there already.
void read_blind(const std::string& dir, Time t_begin, VehicleView& vehicle, RunData& run);

/// ranges.csv, counted and thinned while it is read: for the vehicles that are there already.
void read_ranges_table(const std::string& dir, Time t_begin, RunData& run);

/// Sums up how much of the way was blind and what held it; the ranges heard are there already.
void sum_blind_way(VehicleView& vehicle);

/// rounds.csv, frontiers.csv, loops.csv.
void read_fleet_tables(const std::string& dir, Time t_begin, RunData& run);

/// map.pcd, else map.ply.
void read_map(const std::string& dir, RunData& run);

/// Marks the vehicles that stand in another frame than the map does.
void find_frame_of_map(RunData& run);

/// Lines of settings.yaml whose origin is not "default".
void read_settings(const std::string& dir, RunData& run);

/// The lines of a settings.yaml as text. Its form is that of config::dump_fleet: two blanks per
/// level, the origin as a comment behind the value.
[[nodiscard]] std::vector<SettingLine> settings_other_than_default(const std::string& text);

[[nodiscard]] bool file_exists(const std::string& path);

}  // namespace rali::report
