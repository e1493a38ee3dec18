#include "rali/drive/output/vehicle_files.hpp"

#include <array>
#include <filesystem>

#include "rali/io/files/atomic_file.hpp"

namespace rali::drive {

Status write_vehicle_files(const VehicleRun& run, const std::string& out_dir) {
  std::error_code error;
  for (const char* folder : {"/trajectory", "/degeneracy"}) {
    std::filesystem::create_directories(out_dir + folder, error);
    if (error) return fail(ErrorCode::kMachine, out_dir + folder, error.message());
  }
  const std::string trajectory = out_dir + "/trajectory/" + run.name();
  Status status = io::write_file_atomic(trajectory + ".tum",
                                        trajectory_text(run.poses(), run.T_map_odom(), run.name()));
  if (!status) return status;
  status = io::write_file_atomic(trajectory + ".cov.csv",
                                 trajectory_covariance_text(run.poses(), run.T_map_odom()));
  if (!status) return status;
  return io::write_file_atomic(out_dir + "/degeneracy/" + run.name() + ".csv",
                               degeneracy_text(run.poses(), run.T_map_odom()));
}

Status write_fleet_files(const std::vector<VehicleRun>& runs, const MapJob& job) {
  std::vector<VehicleKeyframes> keyframes;
  for (const VehicleRun& run : runs) {
    keyframes.push_back({run.name(), run.T_map_odom(), &run.keyframes()});
  }
  Status status = io::write_file_atomic(job.out_dir + "/keyframes.csv",
                                        keyframes_text(keyframes, job.write_keyframes));
  if (!status) return status;
  // No loops are looked for yet: an empty table says that none was closed or refused.
  return io::write_file_atomic(
      job.out_dir + "/loops.csv",
      "stamp_from_s,vehicle_from,stamp_to_s,vehicle_to,accepted,reason,score,shift_m\n");
}

}  // namespace rali::drive
