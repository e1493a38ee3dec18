#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "rali/geometry/types.hpp"

namespace rali::places {

struct FreeSpaceSettings {
  double cell_m = 0.2;
  double range_m = 15.0;    ///< farther along a ray nothing is said: rays are too far apart
  double margin_m = 0.4;    ///< the last piece of a ray says nothing
  double height_m = 3.0;    ///< above and below the sensors; beyond nothing is said
  int rays_min = 2;         ///< of which a cell must have been passed
  int rays_max = 30000;     ///< so many are traced, evenly chosen
  int cells_max = 4000000;  ///< the grid is made smaller if it would have more

  template <class V>
  void visit(V& v) {
    v("cell_m", cell_m, 0.05, 2.0, "edge of a cell");
    v("range_m", range_m, 1.0, 100.0, "farther along a ray nothing is said");
    v("margin_m", margin_m, 0.0, 5.0, "the last piece of a ray says nothing");
    v("height_m", height_m, 0.5, 50.0, "beyond so far above or below the sensor nothing is said");
    v("rays_min", rays_min, 1, 100, "rays that must have passed a cell");
    v("rays_max", rays_max, 100, 10000000, "rays that are traced, evenly chosen");
    v("cells_max", cells_max, 1000, 100000000, "cells of the grid at most");
  }
};

/// What the rays of a submap say about a place.
enum class Sight : std::uint8_t {
  kUnknown,
  kFree,  ///< rays went through and on, and nothing is near
  kHit    ///< something is there
};

/// Which cells rays went through and in which they ended: the memory of emptiness that tells a
/// place from its twin (algorithms_fleet 7.5). Bounded: cells_max bytes.
class FreeSpace {
 public:
  /// @param origins where the rays start, one per point; all finite, one frame.
  void build(std::span<const geometry::Vec3f> origins, std::span<const geometry::Vec3f> points,
             const FreeSpaceSettings& settings);

  [[nodiscard]] Sight look(const geometry::Vec3& p_m) const {
    const geometry::Vec3 c = (p_m - low_) * inverse_;
    if (!(c.minCoeff() >= 0.0) || c.x() >= nx_ || c.y() >= ny_ || c.z() >= nz_) {
      return Sight::kUnknown;
    }
    return state_[index(static_cast<int>(c.x()), static_cast<int>(c.y()), static_cast<int>(c.z()))];
  }

  [[nodiscard]] std::size_t cells() const { return state_.size(); }

 private:
  [[nodiscard]] std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(ny_) +
            static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(nx_) +
           static_cast<std::size_t>(x);
  }

  bool lay_out(std::span<const geometry::Vec3f> origins, const FreeSpaceSettings& settings);
  void trace(const geometry::Vec3& from, const geometry::Vec3& to,
             std::vector<std::uint8_t>& passed) const;
  void decide(const std::vector<std::uint8_t>& passed, const std::vector<std::uint8_t>& hit,
              int rays_min);

  geometry::Vec3 low_ = geometry::Vec3::Zero();
  double inverse_ = 1.0;
  int nx_ = 0, ny_ = 0, nz_ = 0;
  std::vector<Sight> state_;
};

}  // namespace rali::places
