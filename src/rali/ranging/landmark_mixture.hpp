#pragma once

#include <vector>

#include <Eigen/Core>

#include "rali/geometry/types.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::ranging {

/// The filter's estimates at the time of a range.
struct MixtureSight {
  geometry::Vec3 p_odom_antenna_m = geometry::Vec3::Zero();
  geometry::Vec3 v_odom_antenna_mps = geometry::Vec3::Zero();
  geometry::Vec3 p_odom_peer_m = geometry::Vec3::Zero();  ///< estimate of the filter
  geometry::Vec3 axis_odom = geometry::Vec3::UnitX();     ///< unit, axis of the own pose's error
  double tau_s = 0.0;  ///< stamps' offset, estimate of the filter
};

struct MixturePrediction {
  double predicted_m = 0.0;  ///< without the filter's estimate of the pair's bias
  double variance_m2 = 0.0;
};

/// Passing a landmark of unknown lateral position in a passage (algorithms 4.3, 5.3).
///
/// Near the antenna a distance is not linear in the lateral position, which may be on either side
/// of the path. A filter that linearises at the wrong one does not recover. So the lateral position
/// is divided into slices, narrow enough to be linear in each. Each slice has its own estimate of
/// all that the ranges depend on - own position and speed along the passage, the peer's position,
/// stamps, biases - and a weight by its likelihood (a Gaussian sum, Alspach and Sorenson 1972). The
/// filter gets mean and covariance of all of them: it commits to a position only when the ranges
/// determine it.
///
/// All quantities are errors of the filter's estimates: their mean is zero after each recentre().
class LandmarkMixture {
 public:
  /// Order of the quantities. A pair's bias is one more, from kBias on.
  enum Index : int { kAlong = 0, kSpeed = 1, kPlace = 2, kAcross = 3, kClock = 4, kBias = 5 };

  static constexpr int kMax = 9;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMax, 1>;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMax, kMax>;

  /// @param along_odom, across_odom level unit vectors: kPlace is the error of the peer's position
  /// along the one, kAcross along the other
  /// @param covariance of the first five quantities, in their order; Gaussian across
  LandmarkMixture(const MixtureSettings& settings, const geometry::Vec3& along_odom,
                  const geometry::Vec3& across_odom, const Matrix& covariance);

  /// Adds one more pair of antennas with the same landmark.
  /// @param covariance of the present quantities, and last the pair's bias, from the filter: a
  /// landmark initialised by this pair is correlated with its bias (it may be one larger than kMax)
  /// @return index of its bias, -1 if there are too many
  int add_bias(const Eigen::Ref<const Eigen::MatrixXd>& covariance);

  /// Propagates over dt_s. Process noise is the gain of the filter's own covariance of the
  /// quantities, in their order. Where it shrank (by the LiDAR or a zero-velocity update), each
  /// slice gets that information too.
  void move(double dt_s, const Matrix& covariance_now);

  /// Bounds the lateral offset of the peer from the own antenna, towards up x axis, by the passage.
  /// Replaces the previous bound.
  void stands_within(const MixtureSight& sight, double mean_m, double sigma_m);

  [[nodiscard]] MixturePrediction predict(const MixtureSight& sight, int bias) const;

  /// @param residual_m measured less predict().predicted_m and less the filter's estimate of the
  /// bias
  /// @param R_m2 variance of the range
  /// @param learns_across false: the range is too long to estimate the lateral position
  void update(const MixtureSight& sight, int bias, double residual_m, double R_m2,
              bool learns_across);

  [[nodiscard]] int size() const { return static_cast<int>(slices_.front().mean.size()); }

  [[nodiscard]] int slices() const { return static_cast<int>(slices_.size()); }

  [[nodiscard]] Vector mean() const;
  [[nodiscard]] Matrix covariance() const;

  /// Of the most likely slice.
  [[nodiscard]] double likeliest_across_m() const;

  [[nodiscard]] const geometry::Vec3& along_odom() const { return along_; }

  [[nodiscard]] const geometry::Vec3& across_odom() const { return across_; }

  /// Call once past the peer. Both sides of the path then explain the ranges about equally, and
  /// agree on all other quantities. Keeps the likelier side; the weight of the other side is added
  /// to the lateral variance.
  void take_side();

  /// Call when the filter has taken over the mean.
  void recentre();

 private:
  struct Slice {
    Vector mean;
    Matrix covariance;
    double log_weight = 0.0;   ///< by the ranges
    double log_passage = 0.0;  ///< by stands_within()
    double weight = 0.0;       ///< normalised
  };

  /// What a slice predicts.
  struct Expected {
    double range_m = 0.0;
    double variance_m2 = 0.0;  ///< second-order term included
    double bend_m2 = 0.0;
    Vector row;
  };

  [[nodiscard]] Expected expected(const Slice& slice, const MixtureSight& sight, int bias) const;
  void learn_zero(int index, double R);
  void learn(Slice& s, const MixtureSight& sight, int bias, double measured_m, double R_m2,
             bool learns_across);
  void normalise();

  MixtureSettings settings_;
  geometry::Vec3 along_, across_;
  std::vector<Slice> slices_;
  Matrix last_;  ///< of the filter, when it took over the mean
};

}  // namespace rali::ranging
