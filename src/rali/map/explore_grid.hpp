#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/base/result.hpp"
#include "rali/map/explore_outline.hpp"
#include "rali/map/voxel_index.hpp"

namespace rali::map {

enum class CellState : std::uint8_t { kUnknown, kFree, kOccupied };

/// A snapshot of an ExploreGrid: cells row by row from the bottom (smallest y). All outside is
/// unknown.
struct CellMap {
  double cell_m = 0.2;
  geometry::Vec2 origin_map_m = geometry::Vec2::Zero();  ///< corner of the lower-left cell
  int width = 0, height = 0;
  std::vector<CellState> cells;

  struct Cell {
    int x = 0, y = 0;
    bool operator==(const Cell&) const = default;
  };

  [[nodiscard]] bool holds(const Cell& c) const {
    return c.x >= 0 && c.y >= 0 && c.x < width && c.y < height;
  }

  [[nodiscard]] std::size_t index(const Cell& c) const {
    return static_cast<std::size_t>(c.y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(c.x);
  }

  [[nodiscard]] Cell cell(std::size_t index) const {
    const auto w = static_cast<std::size_t>(width);
    return {static_cast<int>(index % w), static_cast<int>(index / w)};
  }

  [[nodiscard]] CellState at(const Cell& c) const {
    return holds(c) ? cells[index(c)] : CellState::kUnknown;
  }

  /// The cell of a position; one outside is clamped to two cells beside the map.
  [[nodiscard]] Cell cell_at(const geometry::Vec2& p_map_m) const;
  [[nodiscard]] geometry::Vec2 centre_m(const Cell& c) const;
};

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
  [[nodiscard]] std::uint64_t cells_written() const { return cells_written_; }

  /// True once keyframes were refused because of cells_max; only a coarser grid can hold them.
  [[nodiscard]] bool is_full() const { return full_; }

  /// Errors: kNoAnswer without any cell, kMachine if the box around all cells has more than
  /// cells_max.
  [[nodiscard]] Result<CellMap> picture() const;

  /// Clamped log-odds of the cell at a position; 0: unknown.
  [[nodiscard]] double log_odds_at(const geometry::Vec2& p_map_m) const;

 private:
  static constexpr std::int64_t kTile = 64;

  struct Cell {
    std::uint16_t hits = 0, passes = 0, driven = 0;  ///< keyframes
    std::uint32_t stamp = 0;                         ///< makes each keyframe count once
  };

  struct Keyframe {
    ScanOutline outline;
    geometry::Vec2 p_map_m = geometry::Vec2::Zero();
    double yaw_rad = 0.0;
  };

  [[nodiscard]] std::optional<double> ground_below_body_m(VehicleId vehicle,
                                                          const KeyframeView& keyframe);
  /// Adds (+1) or removes (-1) the evidence of a keyframe.
  void place(const Keyframe& keyframe, int sign);
  void place_hits(const Keyframe& keyframe, int sign);
  void place_free(const Keyframe& keyframe, int sign);
  void place_vehicle(const Keyframe& keyframe, int sign);
  [[nodiscard]] Cell* cell(std::int64_t ix, std::int64_t iy);
  [[nodiscard]] std::vector<Cell>* tile(std::int64_t tx, std::int64_t ty);
  [[nodiscard]] CellState state_of(const Cell& cell) const;
  [[nodiscard]] double log_odds(const Cell& cell) const;

  ExploreSettings settings_;
  std::int64_t reach_;                ///< radius of one keyframe's evidence, cells
  std::vector<std::uint16_t> polar_;  ///< per cell around the sensor: sector
  std::vector<float> polar_m_;        ///< likewise: distance
  std::map<KeyframeId, Keyframe> keyframes_;
  std::map<VehicleId, std::vector<double>> heights_m_;  ///< ground heights so far, sorted
  VoxelIndex tile_index_;
  std::vector<std::vector<Cell>> tiles_;
  std::vector<std::pair<std::int64_t, std::int64_t>> tile_corner_;
  std::uint32_t stamp_ = 0;
  std::uint64_t cells_written_ = 0;
  bool full_ = false;
};

}  // namespace rali::map
