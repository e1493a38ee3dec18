#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>
#include <utility>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/map/cell_map.hpp"
#include "rali/map/scan_outline.hpp"
#include "rali/map/voxel_index.hpp"

namespace rali::map {

/// Counts, per cell of the plane, the keyframes that saw an obstacle in it, those whose rays passed
/// it, and those whose vehicle stood in it. Sums only: the order of keyframes does not matter,
/// grids of several vehicles add up, and a keyframe is removed exactly by placing it with sign -1.
class EvidenceGrid {
 public:
  struct Settings {
    double cell_m = 0.2;
    double range_m = 20.0;          ///< the outlines' longest reach
    double vehicle_radius_m = 0.4;  ///< cells so near to a vehicle's position were free then
    double cells_max = 2e7;
  };

  struct Cell {
    std::uint16_t hits = 0, passes = 0, driven = 0;  ///< keyframes
    std::uint32_t stamp = 0;                         ///< makes each keyframe count once
  };

  explicit EvidenceGrid(const Settings& settings);

  /// Adds (+1) or removes (-1) the evidence of a keyframe whose body is at p_map_m with this
  /// heading.
  void place(const ScanOutline& outline, const geometry::Vec2& p_map_m, double yaw_rad, int sign);

  /// The cell that holds a point of the map; null if no keyframe says anything about it.
  [[nodiscard]] const Cell* find(const geometry::Vec2& p_map_m) const;

  /// Cells visited by all insertions so far: a measure of cost.
  [[nodiscard]] std::uint64_t cells_written() const { return cells_written_; }

  /// True once evidence was left out because of cells_max; only a coarser grid can hold it.
  [[nodiscard]] bool is_full() const { return full_; }

  /// The error of a grid that is_full(), or whose box has more than cells_max cells.
  [[nodiscard]] tl::unexpected<Error> too_large(std::string_view settings_group) const;

  using StateOf = std::function<CellState(const Cell&)>;

  /// @param settings_group where cell_m and ground_below_body_m are set, for the remedies
  /// Errors: kNoAnswer without any cell, kMachine if the box around all cells has more than
  /// cells_max.
  [[nodiscard]] Result<CellMap> picture(const StateOf& state_of,
                                        std::string_view settings_group) const;

 private:
  static constexpr std::int64_t kTile = 64;

  void place_hits(const ScanOutline& o, const geometry::Vec2& p_map_m, double yaw_rad, int sign);
  void place_free(const ScanOutline& o, const geometry::Vec2& p_map_m, double yaw_rad, int sign);
  void place_vehicle(const geometry::Vec2& p_map_m, int sign);
  [[nodiscard]] Cell* cell(std::int64_t ix, std::int64_t iy);
  [[nodiscard]] std::vector<Cell>* tile(std::int64_t tx, std::int64_t ty);

  Settings settings_;
  std::int64_t reach_;                ///< radius of one keyframe's evidence, cells
  std::vector<std::uint16_t> polar_;  ///< per cell around the sensor: sector
  std::vector<float> polar_m_;        ///< likewise: distance
  VoxelIndex tile_index_;
  std::vector<std::vector<Cell>> tiles_;
  std::vector<std::pair<std::int64_t, std::int64_t>> tile_corner_;
  std::uint32_t stamp_ = 0;
  std::uint64_t cells_written_ = 0;
  bool full_ = false;
};

}  // namespace rali::map
