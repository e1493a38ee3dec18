#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "rali/base/time.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::odometry {

/// Quantities outside the vehicle that are estimated together with its state, because what is
/// measured of them depends on both: places of radios, their biases, time offsets. The filter knows
/// them as numbers with a covariance; what they mean, their owner knows.
struct SideStates {
  static constexpr int kMax = 32;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMax, 1>;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMax, kMax>;

  Vector mean;
  Matrix covariance;

  [[nodiscard]] int size() const { return static_cast<int>(mean.size()); }
};

/// The vehicle at one instant between sweeps.
struct Moment {
  Time t;
  geometry::SE3 T_odom_body;
  geometry::Vec3 v_odom_mps = geometry::Vec3::Zero();
  geometry::Vec3 w_body_radps = geometry::Vec3::Zero();
  bool at_rest = false;  ///< the pose is held
};

/// One measured scalar: its residual and how what was predicted moves with the state.
struct SideMeasurement {
  Eigen::Matrix<double, 1, 6> d_pose = Eigen::Matrix<double, 1, 6>::Zero();  ///< boxplus order
  Eigen::RowVector3d d_velocity = Eigen::RowVector3d::Zero();                ///< of v in odom
  SideStates::Vector d_side;  ///< as many as there are side states
  double residual = 0.0;      ///< measured less predicted
  /// First of three side states of which this measurement may move only the part that `estimates`
  /// (a projector) leaves; the rest is considered with its covariance. -1: all is estimated.
  int considered = -1;
  geometry::Mat3 estimates = geometry::Mat3::Identity();
};

/// Some linear functions of a filter's state, by their derivatives; nothing else of the
/// measurements counts.
using SideRowList = std::vector<SideMeasurement>;

/// How measurements between sweeps reach a filter, in order of time.
class SideFilter {
 public:
  virtual ~SideFilter() = default;

  /// Brings the state to time t, at most the end of the next sweep; inertial data up to t are in.
  /// Nothing if the filter has not found itself yet, or t is in its past by more than a sweep.
  [[nodiscard]] virtual std::optional<Moment> advance_to(Time t) = 0;

  [[nodiscard]] virtual const SideStates& side() const = 0;

  /// Appends states: the rows' values, and something else of this covariance that nothing hangs on.
  /// What was measured from the vehicle errs with it: told apart from its error, the next look at
  /// the same would correct the vehicle by its own word.
  /// @param rows one for each new state, or none: nothing hangs on them yet
  /// @return index of the first, -1 if full
  virtual int add_side(const SideStates::Vector& mean, const SideStates::Matrix& covariance,
                       const SideRowList& rows) = 0;

  /// Takes `n` states out; those behind move down.
  virtual void remove_side(int first, int n) = 0;

  /// Side state `index` has wandered by this variance.
  virtual void walk_side(int index, double variance) = 0;

  /// Variance of the prediction, errors of the map included where the pose hangs on the map.
  [[nodiscard]] virtual double variance(const SideMeasurement& measurement) const = 0;

  /// Kalman update with noise variance R. What only the map is wrong by is not corrected: the pose
  /// moves where the LiDAR leaves room. @return the shift of the position in odom [m].
  virtual geometry::Vec3 apply(const SideMeasurement& measurement, double R) = 0;

  /// Of the rows' values, errors of the map left out.
  [[nodiscard]] virtual SideStates::Matrix covariance(const SideRowList& rows) const = 0;

  /// Somebody else estimated these quantities, from the filter's own belief and from more: their
  /// means shift and their covariance is the one given, wider or narrower; all else follows by
  /// regression on them (Jeffrey's rule). @return the shift of the position in odom [m].
  virtual geometry::Vec3 replace(const SideRowList& rows, const SideStates::Vector& shift,
                                 const SideStates::Matrix& covariance) = 0;

  /// The pose was found to be wrong: the variance of position and speed along blind directions is
  /// multiplied.
  virtual void widen(double factor) = 0;

  /// The one horizontal direction along which the LiDAR is blind, unit; nothing if there is none,
  /// or more than one.
  [[nodiscard]] virtual std::optional<geometry::Vec3> blind_axis() const = 0;

  /// Surfaces of the map that the line between two points in odom goes through.
  [[nodiscard]] virtual int surfaces_between(const geometry::Vec3& p_odom_m,
                                             const geometry::Vec3& q_odom_m) const = 0;

  /// Of the body's position in odom, without the map's own error.
  [[nodiscard]] virtual geometry::Mat3 position_covariance() const = 0;
};

}  // namespace rali::odometry
