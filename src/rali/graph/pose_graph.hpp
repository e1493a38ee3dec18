#pragma once

#include <memory>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "rali/graph/loops.hpp"
#include "rali/graph/marginals.hpp"

namespace rali::graph {

/// Mean and covariance of a landmark.
struct LandmarkEstimate {
  geometry::Vec3 p_map_m = geometry::Vec3::Zero();
  geometry::Mat3 covariance = geometry::Mat3::Zero();
};

/// Mean and variance of a bias [m, m^2] or tau [s, s^2].
struct ScalarEstimate {
  double mean = 0.0;
  double variance = 0.0;
};

/// A range as predicted by the graph without its measurement.
struct RangePrediction {
  double range_m = 0.0;      ///< bias and time offset included
  double variance_m2 = 0.0;  ///< of that, without measurement noise
};

/// State of a loop in the graph.
struct LoopState {
  std::uint64_t id = 0;
  double chi2 = 0.0;  ///< at the present values, without weight
  int dof = 0;
  double weight = 0.0;
};

/// Nodes of all vehicles of a fleet in one frame `map`, with all factors: paths, ranges between
/// them, loops, gravity, priors (algorithms_fleet 8). The `odom` in the names of factors and states
/// is `map` here.
///
/// A node is a pose, or a pose with velocity and biases if inertial factors need them. The graph
/// assigns its number, ascending. A prior or fix() must define the map's frame.
///
/// Misuse by the caller is an internal error (RALI_ASSERT): an unknown node, landmark, bias or tau,
/// a number that is not finite, an id that was used before (algorithms_fleet 8.3). Call
/// contains_range() first if a range may be repeated.
class PoseGraph {
 public:
  explicit PoseGraph(const GraphSettings& settings);
  PoseGraph(const PoseGraph& other);
  PoseGraph& operator=(const PoseGraph& other);
  PoseGraph(PoseGraph&&) = default;
  PoseGraph& operator=(PoseGraph&&) = default;
  ~PoseGraph() = default;

  Seq add_pose(const geometry::SE3& T_map_body);
  Seq add_state(const KeyframeState& initial);
  void add_landmark(int number, const geometry::Vec3& p_map_m, const geometry::Mat3& covariance);
  void add_bias(int number, double mean_m, double sigma_m);
  void add_tau(int number, double mean_s, double sigma_s);

  /// Fixes a node at its value, or frees it.
  void fix(Seq seq, bool fixed = true);
  /// Sets another initial pose of a node. Priors keep their mean.
  void set_pose(Seq seq, const geometry::SE3& T_map_body);

  void add(const InertialFactor& factor);
  void add(const RelativePoseFactor& factor);
  void add(const RangeFactor& factor);
  void add(const StandstillFactor& factor);
  void add(const GravityFactor& factor);
  void add(const PriorFactor& factor);
  /// Prior on a pose with this information in geometry::boxplus; velocity and biases stay free.
  void add_pose_prior(Seq seq, const geometry::SE3& mean, const geometry::Mat6& information);
  /// Has no effect before solve_full() has weighted it; with LoopGuard::kNone it counts at once.
  void add(const LoopFactor& factor);

  [[nodiscard]] bool contains(Seq seq) const { return window_.find(seq) >= 0; }

  [[nodiscard]] bool contains(GlobalId id) const { return window_.find(id) >= 0; }

  /// True if the range was ever added.
  [[nodiscard]] bool contains_range(std::uint64_t id) const { return used_ranges_.contains(id); }

  [[nodiscard]] bool contains_loop(std::uint64_t id) const;

  /// Removes a live range; its id stays used. @return false if it is not live.
  bool remove_range(std::uint64_t id);
  /// Changes the sigmas of live ranges. @param sigma_m by id, ascending; the others stay
  void set_range_sigmas(std::span<const std::pair<std::uint64_t, double>> sigma_m);

  /// If the flag is raised, solve(), solve_full() and judge() end early, with their present result.
  void stop_on(StopFlag stop) { stop_ = stop; }

  /// From the present values and with the present loop weights.
  SolveReport solve(int iterations_max);
  /// Weights all loops again by the settings' guard, from recomputed initial values if these are
  /// poor.
  SolveReport solve_full();

  /// Replaces the nodes and their factors by a prior on their neighbours: the separator prior of
  /// earlier rounds (algorithms_fleet 8.5). See graph::marginalise.
  void marginalise(std::vector<Seq> nodes);

  /// The result of marginalise(); without blocks before.
  [[nodiscard]] const DensePrior& separator() const { return window_.dense; }

  /// Continues from the separator prior of another graph. Its nodes and globals must exist here
  /// with the prior's numbers and dimensions. Values start at the prior's linearisation point; it
  /// already contains the priors of its globals. Only allowed before any marginalisation.
  void set_separator_prior(DensePrior prior);

  [[nodiscard]] const KeyframeState& state(Seq seq) const { return window_.node(seq).x; }

  [[nodiscard]] const geometry::SE3& pose(Seq seq) const { return state(seq).T_odom_body; }

  /// By number.
  [[nodiscard]] const std::vector<KeyframeNode>& nodes() const { return window_.keyframes; }

  [[nodiscard]] const GraphSettings& settings() const { return settings_; }

  [[nodiscard]] std::size_t range_count() const { return window_.ranges.size(); }

  /// In the order they were added.
  [[nodiscard]] std::vector<LoopState> loops() const;

  /// Half the squared residuals in sigma at the present values and weights.
  [[nodiscard]] double cost() const;
  /// Residuals minus unknowns.
  [[nodiscard]] int degrees_of_freedom() const;

  // Covariances at the present values and weights. They share one factorisation, made at the first
  // call after a change. Huge for an unobservable node, zero for a fixed one.

  /// Of geometry::boxplus of the pose, rotation first.
  [[nodiscard]] geometry::Mat6 covariance(Seq seq);
  /// Of all nodes, in the order of nodes().
  [[nodiscard]] std::vector<geometry::Mat6> covariances();
  /// Of two different nodes: a first. Request pairs with the same b in a row: each new b costs a
  /// solve of the whole system.
  [[nodiscard]] Eigen::Matrix<double, 12, 12> covariance(Seq a, Seq b);
  [[nodiscard]] LandmarkEstimate landmark(int number);
  [[nodiscard]] ScalarEstimate bias(int number);
  [[nodiscard]] ScalarEstimate tau(int number);
  /// Predicted minus measured range [m], at the present values.
  [[nodiscard]] double residual(const RangeFactor& factor) const;
  /// Predicted range and its variance, with all correlations. The measured value is not used; the
  /// id may be new.
  [[nodiscard]] RangePrediction predict(const RangeFactor& factor);

  /// Tests each candidate against the graph without any loop, in the directions it constrains
  /// (algorithms_fleet 8.4). A copy of the graph is solved without loops, from the present values;
  /// the graph itself is unchanged. Candidates in the settings' band are tried in the graph.
  [[nodiscard]] std::vector<LoopVerdict> judge(const std::vector<RelativePoseFactor>& candidates,
                                               Executor& executor) const;

 private:
  Seq add_node(const KeyframeState& x, int dim);
  ScalarEstimate scalar(GlobalId id);
  Marginals& marginals();
  KeyframeNode& node(Seq seq);
  [[nodiscard]] std::vector<int> pose_columns(Seq seq) const;

  /// Laid out.
  [[nodiscard]] const Window& window() const;

  void changed() { marginals_.reset(); }

  GraphSettings settings_;
  mutable Window window_;  ///< mutable: columns are assigned on demand
  mutable bool laid_out_ = false;
  StopFlag stop_;
  Seq next_ = 0;
  std::set<std::uint64_t> used_ranges_;
  std::unique_ptr<Marginals> marginals_;
};

}  // namespace rali::graph
