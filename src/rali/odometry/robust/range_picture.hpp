#pragma once

#include <cstddef>
#include <vector>

#include "rali/sensor/lidar_scan.hpp"

namespace rali::odometry {

/// The ranges of one scan by direction, as measured. At standstill, later scans repeat them, also
/// in places where planes constrain no pose: a pole or the edge of a niche is enough to show
/// motion.
class RangePicture {
 public:
  explicit RangePicture(const sensor::LidarScan& scan);

  /// Fraction of the points of another scan whose range differs from all that was measured in their
  /// direction; 0 if none can be compared. Noise, dust and edges differ at standstill as well.
  [[nodiscard]] double changed(const sensor::LidarScan& scan) const;

 private:
  static constexpr std::size_t kColumns = 720;  ///< of half a degree

  struct Cell {
    float near_m = 0.0F, far_m = 0.0F;  ///< 0: no point
  };

  [[nodiscard]] static std::size_t column_of(const sensor::LidarScan& scan, std::size_t i);
  [[nodiscard]] std::size_t row_of(const sensor::LidarScan& scan, std::size_t i) const;

  bool by_ring_ = false;
  std::size_t rows_ = 0;
  std::vector<Cell> cells_;  ///< by row, then column
};

/// Motion since the first of several scans: more has changed between it and the last than between
/// it and the second.
[[nodiscard]] bool view_has_changed(const sensor::LidarScan& first, const sensor::LidarScan& second,
                                    const sensor::LidarScan& last);

}  // namespace rali::odometry
