#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/wire/cloud_format.hpp"

namespace rali::inspect {

struct TopicInfo {
  std::string name, type, encoding;
  std::uint64_t messages = 0;
  double rate_hz = 0.0;  ///< by record time; 0 with fewer than two messages
  std::string advice;    ///< for data that resemble LiDAR data but cannot be read
};

/// The first cloud as stored in the file.
struct CloudInfo {
  struct Field {
    std::string name, type;
    std::uint32_t offset = 0, count = 1;
    std::optional<double> first, low, high;  ///< of the first point; over all points
  };

  std::string topic, frame_id;
  Time stamp;
  std::uint32_t width = 0, height = 0, point_step = 0;
  bool big_endian = false;
  std::vector<Field> fields;
  std::string summary;  ///< how RaLI reads it; empty for files without time
};

/// Content of a file or folder.
struct FileInfo {
  std::string path;
  std::string kind;         ///< "recording", "folder of scans", "point cloud"
  std::string compression;  ///< or the encoding of a cloud file
  std::uint64_t bytes = 0;
  std::uint64_t messages = 0;  ///< or scans of a folder
  Time t_start, t_end;
  bool has_span = false;
  bool truncated = false, unindexed = false;
  bool damaged = false;  ///< truncated, or some messages cannot be read
  std::vector<TopicInfo> topics;
  std::vector<std::string> notes;  ///< times.txt, imu.csv, ...
  std::optional<CloudInfo> cloud;
  FindingList findings;
};

/// Inspects a recording (all of it, as a stream), a folder of scans or a cloud. Unknown types are
/// listed like any other.
/// Errors: kInput for any other file, with its kind.
[[nodiscard]] Result<FileInfo> look_into(const std::string& path);

[[nodiscard]] std::string info_text(const FileInfo& info);
/// One JSON document, schema 1.
[[nodiscard]] std::string info_json(const FileInfo& info);

}  // namespace rali::inspect
