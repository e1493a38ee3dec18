#pragma once

#include <vector>

#include <Eigen/Core>

#include "rali/base/time.hpp"
#include "rali/fleet/frames/path_sample.hpp"
#include "rali/fleet/frames/settings.hpp"

namespace rali::fleet {

/// Errors of a path as few independent parameters of unit variance: the scale, tilt about x and y,
/// the heading of each segment of the path, and per segment the axes along which the reported
/// covariance grows. So odometry errors stay correlated along the path, which a sigma added to each
/// measurement would not model (algorithms_fleet 7.4, step 3: C_odo). All vanish at the earliest
/// sample, where the odom frame is defined.
class DriftBasis {
 public:
  /// @param path in any order; empty or at standstill: no parameters
  DriftBasis(std::vector<PathSample> path, const DriftSettings& settings);

  /// Number of parameters.
  [[nodiscard]] Eigen::Index size() const { return size_; }

  /// Column k is the error of (heading, position) [rad, m] of a point of the path if parameter k
  /// is 1.
  [[nodiscard]] Eigen::Matrix4Xd at(Time t, const geometry::Vec3& p_m) const;

 private:
  /// A segment of the path.
  struct Piece {
    double start_m = 0.0, length_m = 0.0;  ///< distances travelled
    geometry::Vec3 middle_m = geometry::Vec3::Zero();
    double yaw_rad = 0.0;                  ///< sigma of the turn in its middle
    std::vector<geometry::Vec3> growth_m;  ///< axes times sigma
  };

  [[nodiscard]] Piece piece(int k) const;
  [[nodiscard]] PathSample at_distance(double s_m) const;
  [[nodiscard]] double distance_at(Time t) const;
  void add_rigid(const geometry::Vec3& p_m, Eigen::Matrix4Xd& out, Eigen::Index& column) const;

  std::vector<PathSample> path_;  ///< by time
  std::vector<double> s_m_;       ///< distance travelled at each sample
  DriftSettings settings_;
  std::vector<Piece> pieces_;
  Eigen::Index size_ = 0;
};

}  // namespace rali::fleet
