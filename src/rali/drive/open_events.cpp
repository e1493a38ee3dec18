#include "rali/drive/open_events.hpp"

#include "rali/drive/folder_events.hpp"
#include "rali/drive/recording_events.hpp"
#include "rali/io/input_kind.hpp"

namespace rali::drive {

Result<std::unique_ptr<ReportedSource>> open_events(const VehicleJob& job) {
  if (job.open) return job.open(job.input);
  if (job.inputs.empty()) {
    return fail(ErrorCode::kUsage, "vehicles." + job.input.vehicle, "no recording given");
  }
  bool scans = false;
  for (const std::string& path : job.inputs) {
    const Result<io::InputKind> kind = io::input_kind(path);
    if (!kind) return tl::make_unexpected(kind.error());
    scans |= *kind == io::InputKind::kScanFolder;
  }
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
