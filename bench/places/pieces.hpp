#pragma once

#include <vector>

#include "rali/places/settings.hpp"
#include "recording.hpp"

namespace rali::recognition {

struct PieceOptions {
  double length_m = 10.0;  ///< of path
  double every_m = 5.0;
  double scan_every_m = 1.0;
};

/// A submap with ground truth.
struct Piece {
  places::Submap submap;
  geometry::SE3 T_world_ref;  ///< true
  places::Descriptor descriptor;
  double make_ms = 0.0, describe_ms = 0.0;
};

/// Cuts each vehicle's trajectory into submaps. Errors: of make_submap().
[[nodiscard]] Result<std::vector<Piece>> cut(const std::vector<Kept>& keyframes,
                                             const PieceOptions& options,
                                             const places::PlacesSettings& settings);

/// True if two submaps have a scan in common.
[[nodiscard]] bool share_scans(const Piece& a, const Piece& b);

}  // namespace rali::recognition
