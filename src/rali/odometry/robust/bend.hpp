#pragma once

#include "rali/geometry/se3.hpp"
#include "rali/odometry/robust/state.hpp"

namespace rali::odometry {

/// How the curvature of a degenerate stretch turns a vehicle whose motion is unobservable.
///
/// In a bent tunnel a scan fits equally well further on, turned by the bend: the unobservable
/// motion is a screw, not a translation. So an error of the position along the axis is also an
/// error of the heading, and a speed error looks like an error of the gyro's bias. Each scan
/// measures the bend with noise of about 3e-4 rad/m. Used scan by scan, these differences would
/// give spurious information on the position along the axis, to centimetres. The unobservable
/// direction must be the same in all scans (Huang, Mourikis, Roumeliotis 2010), hence the mean over
/// some 20 scans.
///
/// While one axis is degenerate, the filter's error state is relative to this screw: heading and
/// gyro bias are the remainder once position and speed along the axis are right. So the LiDAR's
/// information has no entry for the position along the axis, and a correction of position or speed
/// also turns the vehicle (jacobian(), move()).
class Bend {
 public:
  /// Call for each scan in which one axis is degenerate.
  /// @param axis_odom unit vector; its sign may differ from the last one's
  /// @param turn_radpm rotation of the vehicle about up per metre along the axis, from this scan
  /// @param sigma_m of the position along the axis
  void follow(const geometry::Vec3& axis_odom, double turn_radpm, double sigma_m);

  /// All translations are observable again, or more than one is degenerate.
  void end() { *this = Bend{}; }

  [[nodiscard]] bool active() const { return !axis_odom_.isZero(); }

  [[nodiscard]] const geometry::Vec3& axis_odom() const { return axis_odom_; }

  /// Bend at the vehicle's position [rad/m].
  [[nodiscard]] double here_radpm() const { return here_radpm_; }

  /// Mean bend over the stretch in which the present uncertainty along the axis arose [rad/m].
  [[nodiscard]] double gathered_radpm() const { return gathered_radpm_; }

  /// From the filter's error state to that of pose, speed and bias; the identity without a bend.
  [[nodiscard]] StateCov jacobian(const FilterState& state) const;

  /// state (+) jacobian() * delta, with the displacement along the axis as an arc: after tens of
  /// metres its tangent ends in the wall.
  void move(FilterState& state, const StateVec& delta) const;

  /// Covariance (boxplus) of the screw for the position variance along the axis, minus that of the
  /// straight translation: the part missing in the filter's covariance.
  [[nodiscard]] geometry::Mat6 turned_covariance(const FilterState& state) const;

  /// The information of a scan with the screw as its unobservable direction.
  /// @param information without an entry for the position along the axis (boxplus order)
  [[nodiscard]] geometry::Mat6 unseen_in(const geometry::Mat6& information,
                                         const FilterState& state) const;

 private:
  geometry::Vec3 axis_odom_ = geometry::Vec3::Zero();
  double here_radpm_ = 0.0;
  double gathered_radpm_ = 0.0;
  double sigma_m_ = 0.0;
};

}  // namespace rali::odometry
