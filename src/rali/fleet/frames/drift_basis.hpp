#pragma once

#include <vector>

#include <Eigen/Core>

#include "rali/base/time.hpp"
#include "rali/fleet/frames/path_sample.hpp"
#include "rali/fleet/frames/settings.hpp"

namespace rali::fleet {

/// Errors of a path as few independent parameters of unit variance: the scale, tilt about x and y,
/// the heading of each segment of the path, and per piece the axes along which the reported
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
  /// Of a segment of the path, in its middle.
  struct Turn {
    double at_m = 0.0;  ///< distance travelled
    geometry::Vec3 place_m = geometry::Vec3::Zero();
  };

  /// Of the reported covariance over a piece of the path.
  struct Growth {
    double start_m = 0.0;              ///< distance travelled
    std::vector<geometry::Vec3> axes;  ///< times sigma [m]
  };

  void add_turns();
  void add_growth();
  [[nodiscard]] int piece_count() const;
  [[nodiscard]] PathSample at_distance(double s_m) const;
  [[nodiscard]] double distance_at(Time t) const;
  void add_rigid(const geometry::Vec3& p_m, Eigen::Matrix4Xd& out, Eigen::Index& column) const;

  std::vector<PathSample> path_;  ///< by time
  std::vector<double> s_m_;       ///< distance travelled at each sample
  DriftSettings settings_;
  std::vector<Turn> turns_;
  double turn_rad_ = 0.0;  ///< sigma of each
  std::vector<Growth> growth_;
  double piece_m_ = 0.0;  ///< length of a piece
  Eigen::Index size_ = 0;
};

}  // namespace rali::fleet
