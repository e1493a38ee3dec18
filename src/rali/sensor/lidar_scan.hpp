#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "rali/base/time.hpp"

namespace rali::sensor {

/// One scan of a LiDAR: flat arrays, all of the same length, points in the LiDAR frame as
/// measured (not deskewed unless `deskewed`). NaN, zero and out-of-range points are already
/// removed.
struct LidarScan {
  Time t_start;  ///< time of dt_s = 0; dt_s >= 0 for all points
  Time t_end;    ///< time of the last point; equals t_start without point times

  std::vector<float> x_m, y_m, z_m;
  std::vector<float> intensity;     ///< as the sensor gives it; 0 where it gives none
  std::vector<float> dt_s;          ///< seconds after t_start; all 0 without point times
  std::vector<std::uint16_t> ring;  ///< index of the laser; 0 without rings

  bool has_point_times = false;
  bool has_rings = false;
  bool deskewed = false;    ///< all points already refer to t_end
  std::uint16_t rings = 0;  ///< 1 + largest ring index that the sensor can have, 0 if unknown

  std::uint32_t dropped_nan = 0;     ///< not a number, or exactly zero
  std::uint32_t dropped_range = 0;   ///< outside the range limits or inside the self box
  std::uint32_t dropped_time = 0;    ///< with a time outside this scan
  std::uint32_t dropped_return = 0;  ///< second returns of a laser pulse

  [[nodiscard]] std::size_t size() const { return x_m.size(); }

  /// Empties the scan but keeps its memory.
  void clear();
  void reserve(std::size_t n);
  void push_back(float px_m, float py_m, float pz_m, float intens, float dt,
                 std::uint16_t ring_index);
};

}  // namespace rali::sensor
