#include "rali/inspect/scan_folder.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "rali/io/files/text.hpp"

namespace rali::inspect {

Result<ScanFolder> look_for_scans(const std::string& path) {
  namespace fs = std::filesystem;
  ScanFolder out;
  std::error_code error;
  if (!fs::is_directory(path, error)) return out;
  fs::directory_iterator entries(path, error);
  if (error)
    return fail(ErrorCode::kInput, path, "the folder cannot be read", "Check permissions.");
  bool recording = false;
  for (const fs::directory_iterator end; entries != end; entries.increment(error)) {
    if (error) return fail(ErrorCode::kInput, path, "the folder cannot be read", "");
    const std::string name = entries->path().filename().string();
    const std::string kind = io::lower_case(entries->path().extension().string());
    if (kind == ".pcd" || kind == ".ply" || kind == ".bin") {
      out.clouds.push_back(entries->path().string());
    }
    recording =
        recording || kind == ".db3" || kind == ".mcap" || kind == ".bag" || name == "metadata.yaml";
    if (name == "times.txt") out.times_file = entries->path().string();
    if (name == "imu.csv") out.imu_file = entries->path().string();
  }
  if (recording) out.clouds.clear();
  std::sort(out.clouds.begin(), out.clouds.end(),
            [](const std::string& a, const std::string& b) { return io::natural_less(a, b); });
  return out;
}

}  // namespace rali::inspect
