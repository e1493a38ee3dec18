#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/io/files/cloud_file.hpp"

namespace rali::io {

/// One scan of a folder.
struct ScanEntry {
  std::string path;
  Time t;  ///< from times.txt, else assumed
};

/// A folder of scans (product.md section 2): `*.pcd`, `*.ply` or `*.bin` in natural order (2 before
/// 10). `times.txt` has one stamp in seconds a line; without it 10 Hz from 0 is assumed and
/// reported. `imu.csv` and `calib.yaml` are optional.
class ScanFolder {
 public:
  /// Errors: kInput (no folder, no scans, scans of two kinds, wrong number of times).
  [[nodiscard]] static Result<ScanFolder> open(const std::string& path,
                                               const CloudFileOptions& options = {});

  [[nodiscard]] const std::vector<ScanEntry>& entries() const { return entries_; }

  [[nodiscard]] const std::string& path() const { return path_; }

  [[nodiscard]] bool times_assumed() const { return times_assumed_; }

  [[nodiscard]] const std::optional<std::string>& imu_path() const { return imu_path_; }

  [[nodiscard]] const std::optional<std::string>& calib_path() const { return calib_path_; }

  /// True: `cloud` and `t` are the next scan. False: end. A damaged scan is reported in findings()
  /// and skipped; of a truncated KITTI scan the whole points are returned. Errors: kMachine.
  [[nodiscard]] Result<bool> next(CloudFile& cloud, Time& t);

  /// Scans that could not be read so far.
  [[nodiscard]] std::uint64_t skipped() const { return skipped_; }

  /// The error of a folder without a readable cloud: the reason of its first file represents all.
  [[nodiscard]] Error none_readable() const;

  /// Restarts with the first scan.
  void rewind();

  [[nodiscard]] const FindingList& findings() const { return findings_; }

 private:
  ScanFolder(std::string path, CloudFileOptions options)
      : path_(std::move(path)), options_(options) {}

  [[nodiscard]] Status list();
  [[nodiscard]] Status read_times();
  void assume_times();
  void add_finding(const char* id, std::string text, double value);

  std::string path_;
  CloudFileOptions options_;
  std::vector<ScanEntry> entries_;
  std::optional<std::string> times_path_, imu_path_, calib_path_;
  bool times_assumed_ = false;
  std::size_t next_ = 0;
  std::uint64_t skipped_ = 0;
  std::uint64_t named_ = 0;
  FindingList findings_;
};

/// Reads one stamp a line; blank lines and comments (#) are skipped. Stamps must advance.
/// Errors: kInput with file and line.
[[nodiscard]] Result<std::vector<Time>> read_times_txt(const std::string& path);

}  // namespace rali::io
