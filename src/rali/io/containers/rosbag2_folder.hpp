#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"

namespace rali::io {

/// The few keys of metadata.yaml that reading needs.
struct Rosbag2Metadata {
  std::vector<std::string> files;  ///< as listed: with or without a folder before the name
  std::string compression_mode;    ///< "", "FILE", "MESSAGE"
};

/// Finds these keys in any YAML that rosbag2 has written so far. Nothing is required.
[[nodiscard]] Rosbag2Metadata parse_rosbag2_metadata(std::string_view yaml);

/// A rosbag2 folder: which files to read in which order.
struct Rosbag2Folder {
  struct Note {
    Severity severity;
    std::string text;  ///< without full stop
  };

  std::vector<std::string> paths;
  bool zstd_messages = false;
  std::vector<Note> notes;  ///< on missing files
};

/// Lists the recordings of a folder in the order of metadata.yaml, or of the numbers in their
/// names without it. Errors: no recording, several that do not belong together.
[[nodiscard]] Result<Rosbag2Folder> list_rosbag2_folder(const std::string& folder);

}  // namespace rali::io
