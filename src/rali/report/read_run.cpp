#include "rali/report/read_run.hpp"

#include <filesystem>

#include "rali/report/internal/read_parts.hpp"

namespace rali::report {
namespace {

namespace fs = std::filesystem;

std::string name_of_folder(const std::string& dir) {
  fs::path path = fs::path(dir).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  if (path.filename() == "." || path.empty()) {
    std::error_code error;
    path = fs::current_path(error);
  }
  return path.filename().string();
}

}  // namespace

bool file_exists(const std::string& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

Result<RunData> read_run(const std::string& out_dir) {
  std::error_code error;
  if (!fs::is_directory(out_dir, error)) {
    return fail(ErrorCode::kInput, out_dir, "there is no such folder",
                "Give the output folder of rali map.");
  }
  RunData run;
  run.name = name_of_folder(out_dir);
  Time t_start = read_json_files(out_dir, run);
  add_vehicles_of_files(out_dir, run);
  if (!run.metrics_known && run.status.empty() && run.vehicles.empty()) {
    return fail(ErrorCode::kInput, out_dir,
                "holds neither metrics.json nor status.json nor trajectory/*.tum",
                "Give the output folder of rali map.");
  }
  for (VehicleView& vehicle : run.vehicles) read_vehicle(out_dir, t_start, vehicle, run);
  read_ranges_table(out_dir, t_start, run);
  for (VehicleView& vehicle : run.vehicles) sum_degenerate_path(vehicle);
  read_fleet_tables(out_dir, t_start, run);
  read_map(out_dir, run);
  find_frame_of_map(run);
  run.begin = t_start;
  read_settings(out_dir, run);
  return run;
}

}  // namespace rali::report
