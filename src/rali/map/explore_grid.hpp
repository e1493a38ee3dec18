#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/base/result.hpp"
#include "rali/map/evidence_grid.hpp"
#include "rali/map/explore_settings.hpp"
#include "rali/map/ground_height.hpp"
#include "rali/map/scan_outline.hpp"

namespace rali::map {

/// The outlines that exploration needs.
[[nodiscard]] OutlineSettings outline_settings(const ExploreSettings& settings);

/// Free, occupied and unknown space from keyframes of one or many vehicles (algorithms_fleet 9.5).
///
/// A cell counts the keyframes that hit it and those whose rays passed it; its log-odds are their
/// weighted sum, clamped when read. So the order of keyframes does not matter, grids of several
/// vehicles add up, and a keyframe whose pose was corrected is removed and inserted again exactly.
/// Cells that a vehicle has occupied are free.
class ExploreGrid {
 public:
  explicit ExploreGrid(const ExploreSettings& settings);

  /// Adds a keyframe at its T_map_body; a known one is only moved. False if it cannot be used:
  /// lengths differ, the pose is not finite, this vehicle has seen no ground yet, or the grid is
  /// full.
  bool add(KeyframeId id, const KeyframeView& keyframe);

  /// Inserts a keyframe again if its pose differs. False if it is not known.
  bool move(KeyframeId id, const geometry::SE3& T_map_body);

  /// False if it is not known.
  bool remove(KeyframeId id);

  [[nodiscard]] std::size_t keyframes() const { return keyframes_.size(); }

  /// Cells visited by all insertions so far: a measure of cost.
  [[nodiscard]] std::uint64_t cells_written() const { return evidence_.cells_written(); }

  /// True once keyframes were refused because of cells_max; only a coarser grid can hold them.
  [[nodiscard]] bool is_full() const { return evidence_.is_full(); }

  /// Errors: kNoAnswer without any cell, kMachine if the box around all cells has more than
  /// cells_max.
  [[nodiscard]] Result<CellMap> picture() const;

  /// Clamped log-odds of the cell at a position; 0: unknown.
  [[nodiscard]] double log_odds_at(const geometry::Vec2& p_map_m) const;

 private:
  struct Keyframe {
    ScanOutline outline;
    geometry::Vec2 p_map_m = geometry::Vec2::Zero();
    double yaw_rad = 0.0;
  };

  /// Adds (+1) or removes (-1) the evidence of a keyframe.
  void place(const Keyframe& keyframe, int sign);
  [[nodiscard]] CellState state_of(const EvidenceGrid::Cell& cell) const;
  [[nodiscard]] double log_odds(const EvidenceGrid::Cell& cell) const;

  ExploreSettings settings_;
  OutlineSettings outlines_;
  EvidenceGrid evidence_;
  VehicleGround ground_;
  std::map<KeyframeId, Keyframe> keyframes_;
};

}  // namespace rali::map
