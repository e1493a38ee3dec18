#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/drive/vehicle_run.hpp"
#include "rali/map/build_map.hpp"

namespace rali::drive {

/// Statistics of a map.
struct MapNumbers {
  std::size_t points = 0;
  std::size_t removed = 0;
  double thickness_m = 0.0;
  std::vector<map::KeyframeLooks> looks;  ///< agreement of keyframes and map walls
};

/// The keyframes of vehicles that share a frame, by time, with the positions of the other vehicles.
/// `runs` and `job` must outlive it.
[[nodiscard]] map::KeyframeStream map_stream(const std::vector<const VehicleRun*>& runs,
                                             const MapJob& job);

/// Renders the map of vehicles that share a frame from their keyframes on disk and writes map.*,
/// removed.pcd, map_2d.pgm and map_2d.yaml. With a site map.las is written whatever the formats, in
/// site coordinates. Errors: kMachine.
[[nodiscard]] Result<MapNumbers> write_map_files(const std::vector<const VehicleRun*>& runs,
                                                 const MapJob& job,
                                                 const std::optional<SiteFrame>& site,
                                                 Executor& executor, FindingList& findings);

}  // namespace rali::drive
