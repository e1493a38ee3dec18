#pragma once

#include <optional>

#include <Eigen/Core>

#include "rali/geometry/se3.hpp"

namespace rali::odometry {

/// In which direction of its body a vehicle drives. Wheels roll along x (REP-103), so another
/// direction means that the LiDAR is turned against T_body_lidar: the whole path is turned by that
/// angle against the heading of its first pose. Vehicles that crab, or whose body is not ahead
/// along x, drive in another direction too: so nothing is corrected by it.
///
/// Regression over steps of the path: sideways = angle * ahead + lever * turn. A point of the body
/// away from the axle moves sideways in a turn.
class TravelDirection {
 public:
  /// The next pose; steps are taken after some distance.
  /// @param forward_body the vehicle's x axis, and up, as unit vectors of that body
  void add(const geometry::SE3& T_odom_body, const geometry::Vec3& forward_body,
           const geometry::Vec3& up_body);

  /// The next step does not reach back to before now: the pose was not known, or corrected.
  void interrupt() { last_.reset(); }

  struct Angle {
    double left_rad = 0.0;  ///< from the vehicle's x axis to the left
    double sigma_rad = 0.0;
  };

  /// Nothing while it is unknown, or if the vehicle does not drive along x at all.
  [[nodiscard]] std::optional<Angle> angle() const;

 private:
  std::optional<geometry::SE3> last_;
  int steps_ = 0;
  double ahead_m_ = 0.0;  ///< sum of lengths
  Eigen::Matrix2d squares_ = Eigen::Matrix2d::Zero();
  Eigen::Vector2d products_ = Eigen::Vector2d::Zero();
  double sideways_m2_ = 0.0;  ///< sum of squares
};

}  // namespace rali::odometry
