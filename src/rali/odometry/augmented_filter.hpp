#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "rali/base/time.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::odometry {

/// States appended to the vehicle's state, because measurements depend on both: landmarks (radios),
/// their biases, time offsets. The filter treats them as numbers with a covariance; only the caller
/// interprets them.
struct AugmentedStates {
  static constexpr int kMax = 32;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMax, 1>;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMax, kMax>;

  Vector mean;
  Matrix covariance;

  [[nodiscard]] int size() const { return static_cast<int>(mean.size()); }
};

/// The vehicle at one instant between scans.
struct Moment {
  Time t;
  geometry::SE3 T_odom_body;
  geometry::Vec3 v_odom_mps = geometry::Vec3::Zero();
  geometry::Vec3 w_body_radps = geometry::Vec3::Zero();
  bool at_rest = false;  ///< standstill: the pose is kept fixed
};

/// One measured scalar: its residual and the derivatives of its prediction by the state.
struct AugmentedMeasurement {
  Eigen::Matrix<double, 1, 6> d_pose = Eigen::Matrix<double, 1, 6>::Zero();  ///< boxplus order
  Eigen::RowVector3d d_velocity = Eigen::RowVector3d::Zero();                ///< of v in odom
  AugmentedStates::Vector d_augmented;  ///< one entry per augmented state
  double residual = 0.0;                ///< measured minus predicted
  /// First of three augmented states of which this measurement may change only the part that
  /// `estimates` (a projector) keeps; the rest is considered with its covariance. -1: all are
  /// estimated.
  int considered = -1;
  geometry::Mat3 estimates = geometry::Mat3::Identity();
};

/// Linear functions of a filter's state, given by their derivatives; other fields are ignored.
using AugmentedRowList = std::vector<AugmentedMeasurement>;

/// Interface through which measurements between scans update a filter, in order of time.
class AugmentedFilter {
 public:
  virtual ~AugmentedFilter() = default;

  /// Propagates the state to time t, at most the end of the next scan; inertial data up to t have
  /// been added. Nothing if the filter is not initialised, or t is more than a scan in its past.
  [[nodiscard]] virtual std::optional<Moment> advance_to(Time t) = 0;

  [[nodiscard]] virtual const AugmentedStates& augmented() const = 0;

  /// Appends states: the rows' values plus independent noise of this covariance. A quantity
  /// measured from the vehicle shares the error of the vehicle's pose. Without that correlation,
  /// the next measurement of it would correct the vehicle by its own estimate.
  /// @param rows one for each new state, or none: they are uncorrelated with all others
  /// @return index of the first, -1 if full
  virtual int add_states(const AugmentedStates::Vector& mean,
                         const AugmentedStates::Matrix& covariance,
                         const AugmentedRowList& rows) = 0;

  /// Removes `n` states; later ones move down.
  virtual void remove_states(int first, int n) = 0;

  /// Adds this variance to augmented state `index` (random walk).
  virtual void walk_side(int index, double variance) = 0;

  /// Variance of the predicted measurement, including the map error that the pose inherits.
  [[nodiscard]] virtual double variance(const AugmentedMeasurement& measurement) const = 0;

  /// Kalman update with noise variance R. The map's own error is not corrected, so the pose moves
  /// only where the LiDAR leaves uncertainty. @return the shift of the position in odom [m].
  virtual geometry::Vec3 apply(const AugmentedMeasurement& measurement, double R) = 0;

  /// Covariance of the rows' values, without the map's error.
  [[nodiscard]] virtual AugmentedStates::Matrix covariance(const AugmentedRowList& rows) const = 0;

  /// Replaces the distribution of these quantities by an external estimate, made from this filter's
  /// own one and further data. Their means shift and they get the given covariance, wider or
  /// narrower. All other states follow by regression on them (Jeffrey's rule). @return the shift of
  /// the position in odom [m].
  virtual geometry::Vec3 replace(const AugmentedRowList& rows, const AugmentedStates::Vector& shift,
                                 const AugmentedStates::Matrix& covariance) = 0;

  /// Call when the pose proves wrong: multiplies the variance of position and speed along
  /// degenerate directions.
  virtual void widen(double factor) = 0;

  /// The one horizontal direction along which the LiDAR is degenerate, unit; nothing if there is
  /// none, or more than one.
  [[nodiscard]] virtual std::optional<geometry::Vec3> degenerate_axis() const = 0;

  /// Number of surfaces of the map that the line between two points in odom crosses.
  [[nodiscard]] virtual int surfaces_between(const geometry::Vec3& p_odom_m,
                                             const geometry::Vec3& q_odom_m) const = 0;

  /// Covariance of the body's position in odom, without the map's own error.
  [[nodiscard]] virtual geometry::Mat3 position_covariance() const = 0;
};

}  // namespace rali::odometry
