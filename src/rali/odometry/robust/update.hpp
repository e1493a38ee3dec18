#pragma once

#include <array>

#include "rali/degeneracy/information.hpp"
#include "rali/odometry/robust/drift.hpp"
#include "rali/odometry/robust/matcher.hpp"
#include "rali/odometry/robust/settings.hpp"
#include "rali/odometry/robust/state.hpp"

namespace rali::odometry {

/// What one iterated update did.
struct UpdateResult {
  int iterations = 0;
  int matches = 0;
  bool converged = false;
  double residual_rms_m = 0.0;
  double fit = 0.0;         ///< share of the points that lie on planes, robustly weighted, 0 to 1
  double mean_epoch = 0.0;  ///< generation of the planes it was registered with (drift.hpp)
  geometry::Mat6 information =
      geometry::Mat6::Zero();  ///< LiDAR alone, what it cannot know removed
  degeneracy::Axes axes = degeneracy::Axes::Identity();
  MapShare share = MapShare::nothing();  ///< how the pose has followed the map
  /// Projector on the translations that the scan may not touch.
  geometry::Mat3 untouched = geometry::Mat3::Zero();
  std::array<degeneracy::DirectionInfo, 6> directions;
  double bend_radpm = 0.0;     ///< unseen_turn_radpm() along the first axis
  std::array<bool, 3> sees{};  ///< translations of which this scan alone tells something
  /// Where the LiDAR alone has the pose, from the prediction (boxplus); zero where it does not
  /// know.
  geometry::Vec6 lidar_shift = geometry::Vec6::Zero();
  geometry::Mat3 known = geometry::Mat3::Zero();  ///< projector on the translations it knows well
  bool rotation_known = false;
  double nis = 0.0;  ///< of lidar_shift against the covariance of the prediction
};

/// Turned by so much that points at 10 m are not in the cells of their planes: the gyro was at the
/// end of its range, or did not measure for a while. @param P_pose boxplus order
[[nodiscard]] bool is_turned_aside(const geometry::Mat6& P_pose);

/// Moves the state to where prior and LiDAR agree (iterated Kalman filter in information form;
/// the LiDAR's 6x6 information may be singular: blind directions keep the prior).
/// @param start where the iteration begins; the prior is the state's own pose.
/// @param axes_before the physical directions of the last scan.
/// @param blind_before translations taken as blind whatever this scan seems to tell: one scan of
/// many tells something by chance.
/// @param inertial the prior comes from inertial data. Where it is poor (without them, or turned by
/// an unknown angle) the first iterations look into neighbouring cells. With fewer than matches_min
/// matches the state is left as predicted.
[[nodiscard]] UpdateResult update_with_scan(FilterState& state, Matcher& matcher,
                                            const PlaneMap& map, const geometry::SE3& start,
                                            const RobustSettings& settings,
                                            const degeneracy::Axes& axes_before,
                                            const std::array<bool, 3>& blind_before, bool inertial);

/// Ordinary Kalman update with one linear measurement of dimension D.
/// @param H Jacobian (D x 17), @param residual z - h(x), @param R covariance.
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
