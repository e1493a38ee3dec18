#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "rali/geometry/types.hpp"

namespace rali::places {

struct FreeSpaceSettings {
  double cell_m = 0.2;
  double range_m = 15.0;    ///< part of a ray that is used; beyond, rays are too far apart
  double margin_m = 0.4;    ///< last part of a ray that is not used
  double height_m = 3.0;    ///< above and below the sensors; beyond, all is unknown
  int rays_min = 2;         ///< rays that make a cell free; scans that make a hit cell kLoose
  int rays_max = 30000;     ///< maximum traced, evenly chosen
  int cells_max = 4000000;  ///< the grid shrinks if it would have more

  template <class V>
  void visit(V& v) {
    v("cell_m", cell_m, 0.05, 2.0, "edge of a cell");
    v("range_m", range_m, 1.0, 100.0, "free space is marked up to this range");
    v("margin_m", margin_m, 0.0, 5.0, "the last part of a ray marks no free space");
    v("height_m", height_m, 0.5, 50.0,
      "free space is limited to this height above and below the sensor");
    v("rays_min", rays_min, 1, 100, "rays that must have passed a cell");
    v("rays_max", rays_max, 100, 10000000, "rays that are traced, evenly chosen");
    v("cells_max", cells_max, 1000, 100000000, "cells of the grid at most");
  }
};

/// State of a point in a submap's free-space grid.
enum class Sight : std::uint8_t {
  kUnknown,
  kFree,  ///< rays passed through, and no hit is near
  kHit,   ///< a ray ended here
  kLoose  ///< hit, but some scans passed through: it moved, or is a fence
};

/// Origin and end points of one scan's rays. A view.
struct Look {
  geometry::Vec3f origin;
  std::span<const geometry::Vec3f> points;
};

/// Cells that rays passed and cells in which they ended: free-space evidence that separates a place
/// from a look-alike (algorithms_fleet 7.5). Memory: nine bytes per cell during build(), a quarter
/// of a byte afterwards, and only for the bounding box of the known cells.
class FreeSpace {
 public:
  /// @param looks in one frame, all finite
  void build(std::span<const Look> looks, const FreeSpaceSettings& settings);

  [[nodiscard]] Sight look(const geometry::Vec3& p_m) const {
    const std::optional<std::size_t> cell = cell_of(p_m);
    return cell ? state(*cell) : Sight::kUnknown;
  }

  [[nodiscard]] std::size_t cells() const {
    return static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_) *
           static_cast<std::size_t>(nz_);
  }

 private:
  [[nodiscard]] std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(ny_) +
            static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(nx_) +
           static_cast<std::size_t>(x);
  }

  [[nodiscard]] Sight state(std::size_t cell) const {
    return static_cast<Sight>(packed_[cell / 4] >> 2 * (cell % 4) & 3);
  }

  /// Counters per cell.
  struct Counts {
    std::vector<std::uint8_t> passed;   ///< rays
    std::vector<std::uint8_t> hit;      ///< 1: a ray ended here
    std::vector<std::uint8_t> through;  ///< scans that passed a hit cell and hit nothing near it
    std::vector<std::uint16_t> near;    ///< number, from 1, of the last scan with a hit in or
                                        ///< beside it
    std::vector<std::uint16_t> last;    ///< and of the last one counted in `through`
  };

  /// Index of the cell of a point, if it has one.
  [[nodiscard]] std::optional<std::size_t> cell_of(const geometry::Vec3& p_m) const {
    const geometry::Vec3 c = (p_m - low_) * inverse_ - first_;
    if (!(c.minCoeff() >= 0.0) || c.x() >= nx_ || c.y() >= ny_ || c.z() >= nz_) return {};
    return index(static_cast<int>(c.x()), static_cast<int>(c.y()), static_cast<int>(c.z()));
  }

  bool lay_out(std::span<const Look> looks, const FreeSpaceSettings& settings);
  void mark_near(const geometry::Vec3& p, std::uint16_t scan, Counts& counts) const;
  void trace(const geometry::Vec3& from, const geometry::Vec3& to, std::uint16_t scan,
             Counts& counts) const;
  [[nodiscard]] static std::vector<Sight> decided(const Counts& counts, int rays_min);
  void keep_known(const std::vector<Sight>& state);

  geometry::Vec3 low_ = geometry::Vec3::Zero();
  double inverse_ = 1.0;
  geometry::Vec3 first_ = geometry::Vec3::Zero();  ///< integer: offset of the cropped grid in cells
  int nx_ = 0, ny_ = 0, nz_ = 0;
  std::vector<std::uint8_t> packed_;  ///< Sight of four cells each
};

}  // namespace rali::places
