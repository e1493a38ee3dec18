#pragma once

#include "rali/map/evidence_grid.hpp"
#include "rali/map/ground_height.hpp"
#include "rali/map/settings.hpp"

namespace rali::map {

/// The 2-D grid of a finished map, one keyframe after the other: fine cells, and a cell is occupied
/// if enough of the keyframes that see it have hit it.
class GridBuilder {
 public:
  explicit GridBuilder(const GridSettings& settings);

  void add(const KeyframeView& keyframe);

  /// Errors: kNoAnswer without any usable keyframe, kMachine if more than cells_max cells.
  [[nodiscard]] Result<CellMap> finish() const;

 private:
  [[nodiscard]] CellState state_of(const EvidenceGrid::Cell& cell) const;

  GridSettings settings_;
  OutlineSettings outlines_;
  EvidenceGrid evidence_;
  VehicleGround ground_;
};

}  // namespace rali::map
