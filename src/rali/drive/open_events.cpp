#include "rali/drive/open_events.hpp"

#include <algorithm>
#include <filesystem>

#include "rali/drive/folder_events.hpp"
#include "rali/drive/recording_events.hpp"

namespace rali::drive {
namespace {

namespace fs = std::filesystem;

/// A folder with a recording in it (rosbag2) is one; any other folder holds scans.
bool is_scan_folder(const std::string& path) {
  std::error_code error;
  if (!fs::is_directory(path, error)) return false;
  for (fs::directory_iterator it(path, error); !error && it != fs::directory_iterator();
       it.increment(error)) {
    const std::string name = it->path().filename().string();
    const bool recording = name == "metadata.yaml" || name.ends_with(".db3") ||
                           name.ends_with(".db3.zstd") || name.ends_with(".mcap");
    if (recording) return false;
  }
  return !error;
}

}  // namespace

Result<std::unique_ptr<ReportedSource>> open_events(const VehicleJob& job) {
  if (job.open) return job.open(job.input);
  if (job.inputs.empty()) {
    return fail(ErrorCode::kUsage, "vehicles." + job.input.vehicle, "no recording given");
  }
  const bool scans = std::any_of(job.inputs.begin(), job.inputs.end(), is_scan_folder);
  if (!scans) {
    if (!job.imu_file.empty()) {
      return fail(ErrorCode::kUsage, job.imu_file, "--imu is for folders of scans",
                  "A recording's inertial data is found in the recording.");
    }
    return open_recording_events(job.inputs, job.input);
  }
  if (job.inputs.size() > 1) {
    return fail(ErrorCode::kUsage, job.inputs[1],
                "a folder of scans cannot be read together with other inputs",
                "Copy all scans into one folder.");
  }
  return open_folder_events(job.inputs.front(), job.imu_file, job.input);
}

}  // namespace rali::drive
