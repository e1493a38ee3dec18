#pragma once

#include <optional>
#include <vector>

#include "rali/base/time.hpp"
#include "rali/geometry/types.hpp"
#include "rali/ranging/passage_offset.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::ranging {

/// One range to the antenna to be located, and the position of the own antenna.
struct FinderSample {
  Time t;
  geometry::Vec3 p_odom_antenna_m = geometry::Vec3::Zero();
  /// Of that position. Its growth while the samples are gathered counts as an error of speed (of a
  /// vehicle in a tunnel, degenerate along it).
  geometry::Mat3 covariance_m2 = geometry::Mat3::Zero();
  double range_m = 0.0;
  double sigma_m = 0.1;
  /// Unit vector along the passage, if the vehicle is in one. The peer is assumed to be in it too.
  std::optional<geometry::Vec3> passage_odom;
  /// Lateral offset of the peer from the own antenna: by the walls beside both, or bounded by those
  /// beside the own, if they are seen.
  std::optional<LateralOffset> by_walls;
};

/// Estimated position of an antenna at standstill.
struct FoundAnchor {
  geometry::Vec3 p_odom_m = geometry::Vec3::Zero();
  geometry::Mat3 covariance_m2 = geometry::Mat3::Zero();
  bool mirrored = false;  ///< as likely on the other side of a straight path; in the covariance
  /// The position for another bias of the pair is p_odom_m + per_bias (bias - bias_m). The
  /// covariance includes per_bias per_bias' bias_sigma_m^2 for it: an estimator of the bias must
  /// take account of that.
  geometry::Vec3 per_bias = geometry::Vec3::Zero();
  double bias_m = 0.0, bias_sigma_m = 0.0;
};

/// Position of an antenna that is known to be ahead, or behind, in the same passage: the distance
/// along the passage is about the range.
/// @param sample with its passage
/// @param height_m expected height of the other antenna above the own one
/// @param bias_m of the range; the covariance contains neither its variance nor that of the own
/// position
/// @param ahead along the passage as in the sample; false: behind
[[nodiscard]] FoundAnchor place_along_passage(const FinderSettings& settings,
                                              const FinderSample& sample, double height_m,
                                              double bias_m, const geometry::Vec3& up_odom,
                                              bool ahead, const LateralOffset& lateral);

/// Estimates the position of an antenna at standstill from ranges along the own path
/// (algorithms_fleet 7.2, rows A: with one end at standstill, ranges determine its position in the
/// other's frame).
///
/// Least squares for position, pair bias and an error of the own speed, started in many directions
/// around the first range: range-only problems have several minima. A position is returned when no
/// rival explains the ranges as well, except its mirror image across a straight path.
class AnchorFinder {
 public:
  AnchorFinder(const FinderSettings& settings, double bias_m, double bias_sigma_m)
      : settings_(settings), bias_m_(bias_m), bias_sigma_m_(bias_sigma_m) {}

  /// @param height_m expected height of the other antenna above the own one, by lever arms
  /// @param up_odom unit vector against gravity
  /// @return the position, once it is certain
  std::optional<FoundAnchor> add(const FinderSample& sample, double height_m,
                                 const geometry::Vec3& up_odom);

  void reset() { samples_.clear(); }

  [[nodiscard]] std::size_t samples() const { return samples_.size(); }

 private:
  using Vec7 = Eigen::Matrix<double, 7, 1>;  ///< position, bias, error of speed
  using Mat7 = Eigen::Matrix<double, 7, 7>;

  struct Solution {
    Vec7 x = Vec7::Zero();
    Mat7 information = Mat7::Zero();
    double cost = 0.0;  ///< sum of squares in sigma
  };

  [[nodiscard]] bool keep(const FinderSample& sample);
  [[nodiscard]] bool far_in_passage(const FinderSample& sample) const;
  [[nodiscard]] std::optional<FoundAnchor> along_passage() const;
  [[nodiscard]] LateralOffset lateral_now() const;
  [[nodiscard]] Mat7 prior_information() const;
  [[nodiscard]] double linearise(const Vec7& x, Mat7& H, Vec7& g) const;
  [[nodiscard]] Solution refine(Vec7 x) const;
  [[nodiscard]] std::vector<Solution> solutions() const;
  [[nodiscard]] std::optional<FoundAnchor> decide(const std::vector<Solution>& all) const;
  [[nodiscard]] bool is_mirror(const Solution& a, const Solution& b) const;

  FinderSettings settings_;
  double bias_m_, bias_sigma_m_;
  std::vector<FinderSample> samples_;
  geometry::Vec3 up_ = geometry::Vec3::UnitZ();
  double height_m_ = 0.0;
  double asked_at_m_ = 0.0;  ///< travelled when last solved
  double travelled_m_ = 0.0;
};

}  // namespace rali::ranging
