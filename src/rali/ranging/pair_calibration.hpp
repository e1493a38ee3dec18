#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "rali/geometry/types.hpp"

namespace rali::ranging {

/// Prior of a pair of radios before its first range.
struct PairPrior {
  geometry::Vec3 origin_m = geometry::Vec3::Zero();  ///< first position of the peer's body, in odom
  double sigma_m = 0.1;                              ///< of it, along x and y
  double sigma_rad = 0.05;                           ///< of the peer's first heading
  double constant_sigma_m = 0.1;                     ///< of the pair's constant error
  double range_sigma_m = 0.1;                        ///< of one smoothed range
};

/// Preset `paper`: estimates the pair's constant error and the position of the anchor, from ranges
/// where the LiDAR constrains the own position (paper, "Dynamical Initialization"). It is a
/// calibration: it moves no pose.
///
/// Six unknowns. x, y and heading of the peer's frame and the pair's constant persist; x and y of
/// the peer's present position start anew with each stay of the peer. Ranges of a stay are solved
/// together with a Gaussian of all before it. Heights are known. All in odom, z up.
class PairCalibration {
 public:
  explicit PairCalibration(const PairPrior& prior);

  /// The peer is at standstill. @param place_m of its antenna, by the prior and by its reports
  /// @param covariance_m2 of the two paths since the start, without that of the prior
  void start_stay(const geometry::Vec3& place_m, const geometry::Mat3& covariance_m2);

  /// The peer leaves: the estimates of its frame and of the constant are kept.
  void end_stay();

  [[nodiscard]] bool in_stay() const { return place_m_.has_value(); }

  /// Adds a smoothed range at a position of the own antenna that the LiDAR constrains. One nearer
  /// than a metre to the last shares its errors and is left out. @return whether it is used
  bool add(const geometry::Vec3& p_m, double range_m);

  [[nodiscard]] double constant_m() const { return mean_(kConstant); }

  [[nodiscard]] double constant_sigma_m() const;

  /// Of the peer's antenna; only during a stay.
  [[nodiscard]] geometry::Vec3 place_m() const;

  /// Variance of distance plus constant from that point, by position and constant [m^2].
  [[nodiscard]] double variance_m2(const geometry::Vec3& p_m) const;

 private:
  enum Unknown { kX, kY, kHeading, kConstant, kPlaceX, kPlaceY, kSize };

  using Vector = Eigen::Matrix<double, kSize, 1>;
  using Matrix = Eigen::Matrix<double, kSize, kSize>;

  struct Sample {
    geometry::Vec3 p_m;
    double range_m;
  };

  [[nodiscard]] geometry::Vec3 place_at(const Vector& x) const;
  [[nodiscard]] Vector derivative(const Vector& x, const geometry::Vec3& p_m) const;
  void solve();

  PairPrior prior_;
  Vector before_ = Vector::Zero();  ///< mean before the samples of this stay
  Matrix information_before_ = Matrix::Zero();
  Vector mean_ = Vector::Zero();
  Matrix covariance_ = Matrix::Zero();
  std::optional<geometry::Vec3> place_m_;  ///< as start_stay() got it
  std::vector<Sample> samples_;
};

}  // namespace rali::ranging
