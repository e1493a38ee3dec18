#pragma once

#include <memory>
#include <string>

#include "rali/drive/map_run.hpp"
#include "recording.hpp"

namespace rali::campaign {

/// A user's inputs for mapping a recording, and the folder of the outputs.
struct MappingOptions {
  std::vector<std::string> assignments;  ///< of `--set`
  std::string preset = "robust";
  std::string folder;  ///< for fleet.yaml, ranges.csv and the outputs; must exist
};

/// Maps the recording as `rali map fleet.yaml` would, with the sensor data read from memory.
/// Errors: of the mapping.
[[nodiscard]] Result<drive::MapSummary> map_recording(std::shared_ptr<const Recording> recording,
                                                      const MappingOptions& options);

/// The fleet.yaml of the case.
[[nodiscard]] std::string fleet_text(const Recording& recording, const std::string& preset);

}  // namespace rali::campaign
