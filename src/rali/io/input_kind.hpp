#pragma once

#include <string>

#include "rali/base/result.hpp"

namespace rali::io {

enum class InputKind {
  kRecording,   ///< a file, or a folder of rosbag2
  kScanFolder,  ///< *.pcd, *.ply or *.bin
  kCloud        ///< one of them alone
};

/// Kind of an input, by its file names; used by every command. A folder with metadata.yaml is a
/// rosbag2; any other folder must not hold both clouds and recordings.
/// Errors: kInput, if it does not exist (also circular links, names that are too long,
/// no permission) or the folder is neither. kMachine, if the machine failed while looking.
[[nodiscard]] Result<InputKind> input_kind(const std::string& path);

}  // namespace rali::io
