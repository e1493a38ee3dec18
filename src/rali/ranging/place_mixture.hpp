#pragma once

#include <vector>

#include <Eigen/Core>

#include "rali/geometry/types.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::ranging {

/// Where the own antenna is as the filter has it, and what the range leads to.
struct MixtureSight {
  geometry::Vec3 p_odom_antenna_m = geometry::Vec3::Zero();
  geometry::Vec3 v_odom_antenna_mps = geometry::Vec3::Zero();
  geometry::Vec3 p_odom_peer_m = geometry::Vec3::Zero();  ///< as the filter has it
  geometry::Vec3 axis_odom = geometry::Vec3::UnitX();     ///< unit, along which the own pose errs
  double tau_s = 0.0;                                     ///< stamps' offset, as the filter has it
};

struct MixturePrediction {
  double predicted_m = 0.0;  ///< without the pair's bias as the filter has it
  double variance_m2 = 0.0;
};

/// The way past an antenna whose place across a passage is not known (algorithms 4.3, 5.3).
///
/// Near the antenna a distance is no linear function of that place, on either side of the way it
/// may stand, and a filter that linearises at the wrong one does not come back. Here the place
/// across is cut into slices, narrow enough to be linear in each. Each slice has its own belief of
/// what the ranges touch - own place and speed along the passage, the peer's place, stamps, biases
/// - and a weight by how well it predicted (a Gaussian sum, Alspach and Sorenson 1972). The filter
/// gets mean and covariance of all of them: it commits itself to a place when the ranges have told
/// it.
///
/// All quantities are errors of what the filter has: their mean is zero after each recentre().
class PlaceMixture {
 public:
  /// Order of the quantities. A pair's bias is one more, from kBias on.
  enum Index : int { kAlong = 0, kSpeed = 1, kPlace = 2, kAcross = 3, kClock = 4, kBias = 5 };

  static constexpr int kMax = 9;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMax, 1>;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMax, kMax>;

  /// @param along_odom, across_odom level unit vectors: the peer's place errs by kPlace of the one
  ///        and kAcross of the other
  /// @param covariance of the first five quantities, in their order; Gaussian across
  PlaceMixture(const MixtureSettings& settings, const geometry::Vec3& along_odom,
               const geometry::Vec3& across_odom, const Matrix& covariance);

  /// One more pair of antennas to the same place.
  /// @param covariance of the quantities there are, and last the pair's bias, as the filter has it:
  ///        a place that was found by this pair errs with its bias
  ///        (one more than there may be has room, too)
  /// @return index of its bias, -1 if there are too many
  int add_bias(const Eigen::Ref<const Eigen::MatrixXd>& covariance);

  /// Time has passed. Noise is what the filter's own covariance of the quantities, in their order,
  /// gained; where it lost (the LiDAR or a standstill told something), each slice learns it too.
  void move(double dt_s, const Matrix& covariance_now);

  /// How far aside of the own antenna the peer stands, towards up x axis, by the passage. Replaces
  /// what was said before.
  void stands_within(const MixtureSight& sight, double mean_m, double sigma_m);

  [[nodiscard]] MixturePrediction predict(const MixtureSight& sight, int bias) const;

  /// @param residual_m measured less predict().predicted_m and less the bias as the filter has it
  /// @param R_m2 variance of the range
  /// @param learns_across false: from so far away nothing is learned about the place across
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

  /// Once past, both sides of the way explain the ranges about as well, and what they say of all
  /// else is about the same: the likelier side stays, and the place across is as doubtful as the
  /// other side is likely.
  void take_side();

  /// The filter has taken the mean over.
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
    double variance_m2 = 0.0;  ///< bend included
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
  Matrix last_;  ///< of the filter, when it took the mean over
};

}  // namespace rali::ranging
