#include "rali/drive/open_events.hpp"

#include "rali/drive/folder_events.hpp"
#include "rali/drive/recording_events.hpp"
#include "rali/io/input_kind.hpp"

namespace rali::drive {

Result<bool> is_scan_folder(const std::vector<std::string>& inputs, const std::string& imu_file) {
  bool scans = false;
  for (const std::string& path : inputs) {
    const Result<io::InputKind> kind = io::input_kind(path);
    if (!kind) return tl::make_unexpected(kind.error());
    scans |= *kind == io::InputKind::kScanFolder;
  }
  if (!scans && !imu_file.empty()) {
    return fail(ErrorCode::kUsage, imu_file, "--imu is for folders of scans",
                "A recording's inertial data is found in the recording.");
  }
  if (scans && inputs.size() > 1) {
    return fail(ErrorCode::kUsage, inputs[1],
                "a folder of scans cannot be read together with other inputs",
                "Copy all scans into one folder.");
  }
  return scans;
}

Result<std::unique_ptr<ReportedSource>> open_events(const VehicleJob& job) {
  if (job.open) return job.open(job.input);
  if (job.inputs.empty()) {
    return fail(ErrorCode::kUsage, "vehicles." + job.input.vehicle, "no recording given");
  }
  const Result<bool> scans = is_scan_folder(job.inputs, job.imu_file);
  if (!scans) return tl::make_unexpected(scans.error());
  return *scans ? open_folder_events(job.inputs.front(), job.imu_file, job.input)
                : open_recording_events(job.inputs, job.input);
}

}  // namespace rali::drive
