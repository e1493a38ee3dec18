#pragma once

#include <string>

#include "rali/base/result.hpp"

namespace rali::io {

enum class InputKind {
  kRecording,   ///< a file, or a folder of rosbag2
  kScanFolder,  ///< *.pcd, *.ply or *.bin
  kCloud        ///< one of them alone
};

/// What an input is, by the names in it; every command asks here. A folder with metadata.yaml is a
/// rosbag2; else it must not hold clouds and recordings both.
/// Errors: kInput, if nothing is there (also links that lead in a circle, names that are too long,
/// no permission) or the folder is neither. kMachine, if the machine failed while looking.
[[nodiscard]] Result<InputKind> input_kind(const std::string& path);

}  // namespace rali::io
