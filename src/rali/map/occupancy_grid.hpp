#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/map/keyframe_view.hpp"
#include "rali/map/settings.hpp"
#include "rali/map/voxel_index.hpp"

namespace rali::map {

inline constexpr std::uint8_t kFree = 254, kOccupied = 0, kUnknownCell = 205;

/// A grid as Nav2's map_server loads it: row 0 is the top of the image (largest y).
struct OccupancyGrid {
  double cell_m = 0.05;
  geometry::Vec2 origin_map_m = geometry::Vec2::Zero();  ///< corner of the lower-left cell
  std::size_t width = 0, height = 0;
  std::vector<std::uint8_t> cells;  ///< row by row from the top: kFree, kOccupied, kUnknownCell

  /// The cell that holds a point of the map; kUnknownCell outside.
  [[nodiscard]] std::uint8_t at(double x_m, double y_m) const;
};

/// Collects evidence for the 2-D grid, one keyframe after the other.
///
/// Each keyframe is flattened to 720 sectors around the LiDAR. A cell is passed if a ray of its
/// sector was inside the height band above the cell (or below it, on its way to the ground) and no
/// point in the band is nearer in that sector; it is hit if a point in the band lies in it. Rays
/// without return clear nothing, because black or wet walls return nothing.
class GridBuilder {
 public:
  explicit GridBuilder(const GridSettings& settings);

  void add(const KeyframeView& keyframe);

  /// Errors: kNoAnswer without any usable keyframe, kMachine if more than cells_max cells.
  [[nodiscard]] Result<OccupancyGrid> finish() const;

 private:
  static constexpr int kTile = 64;

  struct Cell {
    std::uint16_t hits = 0, passes = 0;
    std::uint32_t last_hit = 0;  ///< makes each keyframe count once
  };

  void flatten(const KeyframeView& keyframe, const geometry::SE3& T_map_lidar, double ground_z_m);
  void add_ray(const geometry::Vec3& p_map, const geometry::SE3& T_map_lidar, double ground_z_m);
  void mark_free(const geometry::Vec3& sensor_map_m);
  [[nodiscard]] std::optional<double> ground_below_body_m(const KeyframeView& keyframe);
  /// Null once the grid has grown beyond its limit.
  [[nodiscard]] Cell* cell(std::int64_t ix, std::int64_t iy);
  [[nodiscard]] bool is_occupied(const Cell& cell) const;

  GridSettings settings_;
  std::size_t bins_;                ///< distance steps of one cell
  std::vector<std::int16_t> open_;  ///< sector x bin: rays that begin minus rays that end here
  std::vector<std::uint16_t> first_hit_;  ///< per sector: bin of the nearest obstacle
  std::vector<std::uint16_t> polar_;      ///< per cell around the sensor: sector
  std::vector<std::uint16_t> polar_bin_;  ///< likewise: bin
  VoxelIndex tile_index_;
  std::vector<std::vector<Cell>> tiles_;
  std::vector<std::pair<std::int64_t, std::int64_t>> tile_corner_;
  std::vector<double> ground_heights_m_;  ///< so far, sorted
  std::uint32_t keyframes_ = 0;
  bool too_large_ = false;
};

}  // namespace rali::map
