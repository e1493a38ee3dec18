#pragma once

#include <array>

#include "rali/degeneracy/information.hpp"
#include "rali/odometry/robust/drift.hpp"
#include "rali/odometry/robust/matcher.hpp"
#include "rali/odometry/robust/settings.hpp"
#include "rali/odometry/robust/state.hpp"

namespace rali::odometry {

/// Result of one iterated update.
struct UpdateResult {
  int iterations = 0;
  int matches = 0;
  bool converged = false;
  double residual_rms_m = 0.0;
  double fit = 0.0;         ///< fraction of the points on planes, robustly weighted, 0 to 1
  double mean_epoch = 0.0;  ///< generation of the planes it was registered with (drift.hpp)
  geometry::Mat6 information = geometry::Mat6::Zero();  ///< LiDAR alone, spurious part removed
  degeneracy::Axes axes = degeneracy::Axes::Identity();
  MapFollowing following = MapFollowing::nothing();  ///< how the pose has followed the map
  /// Projector on the translations that the scan must not change.
  geometry::Mat3 untouched = geometry::Mat3::Zero();
  std::array<degeneracy::DirectionInfo, 6> directions;
  double bend_radpm = 0.0;     ///< turn about up of degeneracy::least_motion() along the first axis
  std::array<bool, 3> sees{};  ///< translations that this scan alone observes
  /// Pose by the LiDAR alone, relative to the prediction (boxplus); zero along unobservable
  /// directions.
  geometry::Vec6 lidar_shift = geometry::Vec6::Zero();
  geometry::Mat3 known = geometry::Mat3::Zero();  ///< projector on the well observable translations
  geometry::Mat3 rotation_known = geometry::Mat3::Zero();  ///< the same for rotations, in body
  double nis = 0.0;  ///< of lidar_shift against the covariance of the prediction
};

/// The rotation is so uncertain that points at 10 m may miss the cells of their planes: the gyro
/// was at the limit of its range, or did not measure for a while. @param P_pose boxplus order
[[nodiscard]] bool is_rotation_uncertain(const geometry::Mat6& P_pose);

/// Moves the state to the joint optimum of prior and LiDAR (iterated Kalman filter in information
/// form; the LiDAR's 6x6 information may be singular: degenerate directions keep the prior).
/// @param start initial pose of the iteration; the prior is the state's own pose.
/// @param axes_before the physical directions of the last scan.
/// @param degenerate_before translations treated as degenerate whatever this scan's information:
/// one scan of many has some by chance.
/// @param inertial the prior comes from inertial data. If it is poor (without them, or turned by an
/// unknown angle) the first iterations also search neighbouring cells. With fewer than matches_min
/// matches the state stays as predicted.
[[nodiscard]] UpdateResult update_with_scan(FilterState& state, Matcher& matcher,
                                            const PlaneMap& map, const geometry::SE3& start,
                                            const RobustSettings& settings,
                                            const degeneracy::Axes& axes_before,
                                            const std::array<bool, 3>& degenerate_before,
                                            bool inertial);

/// Ordinary Kalman update with one linear measurement of dimension D.
/// @param H Jacobian (D x kStateDim), @param residual z - h(x), @param R covariance.
template <int D>
void update_linear(FilterState& state, const Eigen::Matrix<double, D, kStateDim>& H,
                   const Eigen::Matrix<double, D, 1>& residual,
                   const Eigen::Matrix<double, D, D>& R);

extern template void update_linear<1>(FilterState&, const Eigen::Matrix<double, 1, kStateDim>&,
                                      const Eigen::Matrix<double, 1, 1>&,
                                      const Eigen::Matrix<double, 1, 1>&);
extern template void update_linear<3>(FilterState&, const Eigen::Matrix<double, 3, kStateDim>&,
                                      const Eigen::Matrix<double, 3, 1>&,
                                      const Eigen::Matrix<double, 3, 3>&);
extern template void update_linear<2>(FilterState&, const Eigen::Matrix<double, 2, kStateDim>&,
                                      const Eigen::Matrix<double, 2, 1>&,
                                      const Eigen::Matrix<double, 2, 2>&);

}  // namespace rali::odometry
