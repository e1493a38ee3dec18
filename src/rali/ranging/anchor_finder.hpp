#pragma once

#include <optional>
#include <vector>

#include "rali/base/time.hpp"
#include "rali/geometry/types.hpp"
#include "rali/ranging/passage_aside.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::ranging {

/// One range to the antenna that is looked for, and where the own antenna was.
struct FinderSample {
  Time t;
  geometry::Vec3 p_odom_antenna_m = geometry::Vec3::Zero();
  /// Of that position: what of it grows while the samples are gathered is taken for an error of
  /// speed (a vehicle that is blind along a tunnel).
  geometry::Mat3 covariance_m2 = geometry::Mat3::Zero();
  double range_m = 0.0;
  double sigma_m = 0.1;
  /// Unit vector along the passage that the vehicle is in, where it is in one: whoever is heard
  /// there stands in it too.
  std::optional<geometry::Vec3> passage_odom;
  /// How far aside of the own antenna the other is by the walls beside both, or may be by those
  /// beside the own, if they are seen.
  std::optional<Aside> by_walls;
};

/// Where an antenna stands.
struct FoundAnchor {
  geometry::Vec3 p_odom_m = geometry::Vec3::Zero();
  geometry::Mat3 covariance_m2 = geometry::Mat3::Zero();
  bool mirrored = false;  ///< as likely on the other side of a straight way; in the covariance
  /// The place for another bias of the pair: p_odom_m + per_bias (bias - bias_m). Of the
  /// covariance, per_bias per_bias' bias_sigma_m^2 is by that: whoever estimates the bias, too,
  /// must know.
  geometry::Vec3 per_bias = geometry::Vec3::Zero();
  double bias_m = 0.0, bias_sigma_m = 0.0;
};

/// Where an antenna stands that is known to stand ahead, or behind, in the same passage: about as
/// far that way as the range says.
/// @param sample with its passage
/// @param height_m how much higher than the own antenna the other one should be
/// @param bias_m of the range; its doubt is not in the covariance, neither is the own position's
/// @param ahead along the passage as the sample has it; false: behind
[[nodiscard]] FoundAnchor place_along_passage(const FinderSettings& settings,
                                              const FinderSample& sample, double height_m,
                                              double bias_m, const geometry::Vec3& up_odom,
                                              bool ahead, const Aside& aside);

/// Finds the place of an antenna that stands, from ranges along the own way (algorithms_fleet 7.2,
/// rows A: with one standing end, its place in the other's frame is what ranges tell).
///
/// Least squares for place, pair bias and an error of the own speed, begun in many directions
/// around the first range: range-only problems have several minima. A place is told when no rival
/// explains the ranges as well, but for its mirror image across a straight way.
class AnchorFinder {
 public:
  AnchorFinder(const FinderSettings& settings, double bias_m, double bias_sigma_m)
      : settings_(settings), bias_m_(bias_m), bias_sigma_m_(bias_sigma_m) {}

  /// @param height_m how much higher than the own antenna the other one should be: from lever arms
  /// @param up_odom unit vector against gravity
  /// @return the place, once it is certain
  std::optional<FoundAnchor> add(const FinderSample& sample, double height_m,
                                 const geometry::Vec3& up_odom);

  void reset() { samples_.clear(); }

  [[nodiscard]] std::size_t samples() const { return samples_.size(); }

 private:
  using Vec7 = Eigen::Matrix<double, 7, 1>;  ///< place, bias, error of speed
  using Mat7 = Eigen::Matrix<double, 7, 7>;

  struct Solution {
    Vec7 x = Vec7::Zero();
    Mat7 information = Mat7::Zero();
    double cost = 0.0;  ///< sum of squares in sigma
  };

  [[nodiscard]] bool keep(const FinderSample& sample);
  [[nodiscard]] bool far_in_passage(const FinderSample& sample) const;
  [[nodiscard]] std::optional<FoundAnchor> along_passage() const;
  [[nodiscard]] Aside aside_now() const;
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
