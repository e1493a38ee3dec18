#pragma once

#include <map>
#include <memory>
#include <optional>

#include "rali/graph/marginals.hpp"
#include "rali/graph/settings.hpp"
#include "rali/graph/solver.hpp"

namespace rali::graph {

/// Mean and covariance of a landmark.
struct LandmarkEstimate {
  geometry::Vec3 p_odom_m = geometry::Vec3::Zero();
  geometry::Mat3 covariance = geometry::Mat3::Zero();
};

/// Mean and variance of a bias [m, m^2] or tau [s, s^2].
struct ScalarEstimate {
  double mean = 0.0;
  double variance = 0.0;
};

/// The last keyframes of one vehicle with all that ties them together: inertial deltas, LiDAR,
/// ranges to peers that stand, what is known beforehand (algorithms 6). Everything is in odom.
///
/// What the caller does wrong is an internal error (RALI_ASSERT): keyframes out of order, an
/// unknown keyframe, landmark, bias or tau, a number that is not finite, and a range that was used
/// already (algorithms 5.4). Ask contains_range() first where a range may come twice.
class LocalGraph {
 public:
  explicit LocalGraph(const LocalGraphSettings& settings);

  /// Appends a keyframe; seq and t grow.
  void add_keyframe(Seq seq, Time t, const KeyframeState& initial);
  void add_landmark(int number, const geometry::Vec3& p_odom_m, const geometry::Mat3& covariance);
  void add_bias(int number, double mean_m, double sigma_m);
  void add_tau(int number, double mean_s, double sigma_s);

  void add(const InertialFactor& factor);
  /// In place of the one between the same keyframes, integrated again at another bias.
  void replace(const InertialFactor& factor);
  void add(const RelativePoseFactor& factor);
  void add(const RangeFactor& factor);
  void add(const StandstillFactor& factor);
  void add(const HeightFactor& factor);
  void add(const PriorFactor& factor);

  [[nodiscard]] bool contains(Seq seq) const { return window_.find(seq) >= 0; }

  [[nodiscard]] bool contains(GlobalId id) const { return window_.find(id) >= 0; }

  /// True if the range is in the graph, was marginalised with a keyframe or was removed. Ranges
  /// older than the oldest keyframe less `range_memory_s` are forgotten, and refused if they come.
  [[nodiscard]] bool contains_range(std::uint64_t id) const { return used_ranges_.contains(id); }

  /// Takes a live range out again; it stays used. @return false if it is not live.
  bool remove_range(std::uint64_t id);

  /// Lets a landmark, bias or tau wander by this variance [m^2, s^2].
  void relax(GlobalId id, double variance);
  /// Says that no range will use it any more: it leaves with the last keyframe that knows it.
  void retire(GlobalId id);
  /// Puts the oldest of two or more keyframes and all that touches it into the prior.
  void marginalise_oldest();

  SolveReport solve(int iterations_max);

  [[nodiscard]] const KeyframeState& state(Seq seq) const;

  /// Oldest first.
  [[nodiscard]] const std::vector<KeyframeNode>& keyframes() const { return window_.keyframes; }

  [[nodiscard]] const LocalGraphSettings& settings() const { return settings_; }

  [[nodiscard]] std::size_t range_count() const { return window_.ranges.size(); }

  /// Half the squared residuals in sigma at the present values (robust loss on ranges).
  [[nodiscard]] double cost() const;

  // Covariances at the present values. They share one factorisation, made at the first question
  // after a change: that is why they are not const.

  /// Of geometry::boxplus of the pose, rotation first. Huge where nothing holds it.
  [[nodiscard]] geometry::Mat6 covariance(Seq seq);
  /// The same of all keyframes, in their order, at the price of one more factorisation: one by one
  /// the time would grow with the square of a recording.
  [[nodiscard]] std::vector<geometry::Mat6> covariances() const;
  /// Of the newest keyframe's pose, velocity and biases, in the order of StateIndex.
  [[nodiscard]] StateMat newest_covariance();
  [[nodiscard]] LandmarkEstimate landmark(int number);
  [[nodiscard]] ScalarEstimate bias(int number);
  [[nodiscard]] ScalarEstimate tau(int number);
  /// What this range would read less what it read [m], at the present values.
  [[nodiscard]] double residual(const RangeFactor& factor) const;
  /// What this range would read, and how well that is known, all correlations included. The
  /// measured value is not used; the id may be new.
  [[nodiscard]] RangePrediction predict(const RangeFactor& factor);
  /// The live range that fits worst to all else; none without ranges. For the guard of
  /// algorithms 6.3.
  [[nodiscard]] std::optional<RangeNis> largest_nis_range();

 private:
  ScalarEstimate scalar(GlobalId id);
  const Marginals& marginals();

  void changed() { marginals_.reset(); }

  LocalGraphSettings settings_;
  Window window_;
  std::map<std::uint64_t, Time> used_ranges_;
  std::unique_ptr<Marginals> marginals_;
};

}  // namespace rali::graph
