#pragma once

#include "rali/geometry/se3.hpp"
#include "rali/odometry/robust/state.hpp"

namespace rali::odometry {

/// How a place turns a vehicle that moves in it unseen.
///
/// In a bent tunnel a scan fits as well further on, turned by the bend: the motion that the LiDAR
/// does not see is a screw, not a translation. So an error of the position along the axis is an
/// error of the heading as well, and one of the speed looks like an error of the gyro's bias. Each
/// scan measures the bend with noise of some 3e-4 rad/m; taken scan by scan, the differences
/// between them would fix the position along the axis to centimetres, of which no scan knows
/// anything. The direction that is not observed must be the same in all scans (Huang, Mourikis,
/// Roumeliotis 2010), hence the mean over a few metres.
///
/// While one axis is degenerate the error state of the filter is about this screw: its heading and
/// gyro bias are what is left when the position and speed along the axis are right. So the
/// LiDAR's information has no entry for the position along the axis, and whoever corrects position
/// or speed turns the vehicle with them (jacobian(), move()).
class Bend {
 public:
  /// One more scan in which one axis is degenerate.
  /// @param axis_odom unit vector; its sense may differ from the last one's
  /// @param turn_radpm turn of the vehicle about up per metre along the axis, by this scan
  /// @param sigma_m of the position along the axis
  void follow(const geometry::Vec3& axis_odom, double turn_radpm, double sigma_m);

  /// The LiDAR sees all translations again, or more than one not.
  void end() { *this = Bend{}; }

  [[nodiscard]] bool active() const { return !axis_odom_.isZero(); }

  [[nodiscard]] const geometry::Vec3& axis_odom() const { return axis_odom_; }

  /// Of the place where the vehicle is [rad/m].
  [[nodiscard]] double here_radpm() const { return here_radpm_; }

  /// Mean over where the present uncertainty along the axis has come about [rad/m].
  [[nodiscard]] double gathered_radpm() const { return gathered_radpm_; }

  /// From the filter's error state to that of pose, speed and bias; the identity without a bend.
  [[nodiscard]] StateCov jacobian(const FilterState& state) const;

  /// state (+) jacobian() * delta, the way along the axis taken as the arc that it is: after tens
  /// of metres the tangent ends in the wall.
  void move(FilterState& state, const StateVec& delta) const;

  /// Covariance (boxplus) of the heading and the position along the axis that one of position has
  /// brought with it, less its own part: what the filter's covariance lacks.
  [[nodiscard]] geometry::Mat6 turned_covariance(const FilterState& state) const;

  /// The information of a scan with the screw as what it does not see.
  /// @param information without an entry for the position along the axis (boxplus order)
  [[nodiscard]] geometry::Mat6 unseen_in(const geometry::Mat6& information,
                                         const FilterState& state) const;

 private:
  geometry::Vec3 axis_odom_ = geometry::Vec3::Zero();
  double here_radpm_ = 0.0;
  double gathered_radpm_ = 0.0;
  double sigma_m_ = 0.0;
};

/// Turn about up of a vehicle that moves a metre along the axis, if no scan is to see it.
/// @param information of one scan at the state's pose, boxplus order
[[nodiscard]] double unseen_turn_radpm(const geometry::Mat6& information,
                                       const geometry::Vec3& axis_odom, const FilterState& state);

}  // namespace rali::odometry
