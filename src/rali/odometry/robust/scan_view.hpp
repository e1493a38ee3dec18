#pragma once

#include <cstdint>
#include <vector>

#include "rali/odometry/deskew.hpp"

namespace rali::odometry {

/// Agreement of two scans where their views overlap, for a given relative pose.
struct ViewAgreement {
  int agree = 0;    ///< points at which the other scan has a surface, too
  int through = 0;  ///< points that rays of the other scan passed through: a contradiction

  /// Fraction of contradictions, 0 to 1; 0 when nothing can be compared.
  [[nodiscard]] double conflict() const {
    const int n = agree + through;
    return n > 0 ? static_cast<double>(through) / n : 0.0;
  }
};

/// A scan as ranges by direction (cells of 4 degrees). If a point of another scan lies in front of
/// the surface that a ray hit, one of the two poses is wrong. If it lies behind, it was occluded,
/// which is also true in a new room. So, unlike the fraction of points that match the map, this
/// distinguishes a wrong pose from a new place.
class ScanView {
 public:
  /// @param points_body one scan; rays start at `p_body_lidar`.
  ScanView(const BodyPoints& points_body, const geometry::Vec3& p_body_lidar);

  /// The other scan's points in this view.
  /// @param T_this_other pose of the other scan's LiDAR in this one's.
  [[nodiscard]] ViewAgreement points_of(const ScanView& other,
                                        const geometry::SE3& T_this_other) const;

  /// points_of() in both directions.
  [[nodiscard]] ViewAgreement compare(const ScanView& other,
                                      const geometry::SE3& T_this_other) const;

 private:
  static constexpr int kRows = 45;
  static constexpr int kColumns = 90;

  struct Cell {
    float near_m = 0.0F;  ///< nearest and farthest point; 0: no point
    float far_m = 0.0F;
  };

  [[nodiscard]] static int row_of(const geometry::Vec3f& p, float range_m);
  [[nodiscard]] static int column_of(const geometry::Vec3f& p);
  void count(const std::vector<geometry::Vec3f>& points, const geometry::SE3& T_this_points,
             ViewAgreement& out) const;

  std::vector<geometry::Vec3f> points_;  ///< relative to the LiDAR
  std::vector<Cell> cells_;              ///< by row, then column
};

}  // namespace rali::odometry
