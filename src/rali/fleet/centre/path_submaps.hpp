#pragma once

#include <span>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/base/settings.hpp"
#include "rali/base/stop_flag.hpp"
#include "rali/fleet/path/vehicle_path.hpp"
#include "rali/places/settings.hpp"

namespace rali::fleet {

/// How paths are cut into pieces for comparison.
struct CutSettings {
  double length_m = 8.0;
  double step_m = 4.0;
  int scans_max = 24;

  template <class V>
  void visit(V& v) {
    v("length_m", length_m, 1.0, 100.0, "distance travelled in one submap");
    v("step_m", step_m, 0.5, 100.0, "distance travelled from one submap to the next");
    v("scans_max", scans_max, 1, 1000, "largest number of keyframes in a submap");
  }
};

/// A piece of a vehicle's path with the points observed from it.
struct PathSubmap {
  std::size_t path = 0;      ///< index in the list of paths
  std::size_t node = 0;      ///< index of the middle keyframe's node in its path
  double path_m = 0.0;       ///< from the path's start to the middle; a leap counts as one piece
  geometry::SE3 T_odom_ref;  ///< of the submap's frame
  places::Submap submap;
  places::Descriptor descriptor;
};

/// Cuts paths into pieces, each with its keyframes' points if those have arrived.
/// @param begins index of the first node of each path that is used; empty: all are used
/// @param stop if it is raised, pieces are missing
[[nodiscard]] std::vector<PathSubmap> cut_into_submaps(std::span<const VehiclePath> paths,
                                                       const CutSettings& cut,
                                                       const places::PlacesSettings& places,
                                                       Executor& executor,
                                                       std::span<const std::size_t> begins = {},
                                                       StopFlag stop = {});

}  // namespace rali::fleet
