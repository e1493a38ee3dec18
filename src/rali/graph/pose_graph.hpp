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

/// A range as the graph expects it without having seen it.
struct RangePrediction {
  double range_m = 0.0;      ///< bias and time offset included
  double variance_m2 = 0.0;  ///< of that, without the noise of the measurement
};

/// A loop as the graph has it.
struct LoopState {
  std::uint64_t id = 0;
  double chi2 = 0.0;  ///< at the present values, weight not counted
  int dof = 0;
  double weight = 0.0;
};

/// Nodes of all vehicles of a fleet in one frame `map`, with all that ties them together: paths,
/// ranges between them, loops, gravity, what is known beforehand (algorithms_fleet 8). The `odom`
/// in the names of factors and states is `map` here.
///
/// A node is a pose, or a pose with velocity and biases where inertial factors need them. Its
/// number is given by the graph and grows. Something must hold the map's frame: a prior or fix().
///
/// What the caller does wrong is an internal error (RALI_ASSERT): an unknown node, landmark, bias
/// or tau, a number that is not finite, an id that was there before (algorithms_fleet 8.3). Ask
/// contains_range() first where a range may come twice.
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

  /// Holds a node exactly where it is, or frees it.
  void fix(Seq seq, bool fixed = true);
  /// Another start for a node. Priors keep their mean.
  void set_pose(Seq seq, const geometry::SE3& T_map_body);

  void add(const InertialFactor& factor);
  void add(const RelativePoseFactor& factor);
  void add(const RangeFactor& factor);
  void add(const StandstillFactor& factor);
  void add(const GravityFactor& factor);
  void add(const PriorFactor& factor);
  /// A pose known with this covariance of geometry::boxplus; velocity and biases stay open.
  void add_pose_prior(Seq seq, const geometry::SE3& mean, const geometry::Mat6& information);
  /// Does not count before solve_full() has weighed it; with LoopGuard::kNone it counts at once.
  void add(const LoopFactor& factor);

  [[nodiscard]] bool contains(Seq seq) const { return window_.find(seq) >= 0; }

  [[nodiscard]] bool contains(GlobalId id) const { return window_.find(id) >= 0; }

  /// True if the range was ever added.
  [[nodiscard]] bool contains_range(std::uint64_t id) const { return used_ranges_.contains(id); }

  [[nodiscard]] bool contains_loop(std::uint64_t id) const;

  /// Takes a live range out; it stays used. @return false if it is not live.
  bool remove_range(std::uint64_t id);
  /// Says anew how well live ranges are known. @param sigma_m by id, ascending; the rest stay
  void set_range_sigmas(std::span<const std::pair<std::uint64_t, double>> sigma_m);

  /// Where the flag is raised, solve(), solve_full() and judge() end early, with what they have.
  void stop_on(StopFlag stop) { stop_ = stop; }

  /// From the present values and with the present weights of the loops.
  SolveReport solve(int iterations_max);
  /// Weighs all loops anew by the settings' guard, from a start made anew if this one is poor.
  SolveReport solve_full();

  /// Puts what touches the nodes into a prior on their neighbours and removes them: the boundary
  /// of earlier rounds (algorithms_fleet 8.5). See graph::marginalise.
  void marginalise(std::vector<Seq> nodes);

  /// What marginalise() has left; without blocks before.
  [[nodiscard]] const DensePrior& boundary() const { return window_.dense; }

  /// Goes on from the boundary of another graph, whose nodes and globals are here under the numbers
  /// that the prior has, with as many unknowns. Values start where the prior was linearised; what
  /// was known of its globals beforehand is in it. Only where nothing was marginalised yet.
  void set_boundary(DensePrior prior);

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
  /// Residuals less unknowns.
  [[nodiscard]] int degrees_of_freedom() const;

  // Covariances at the present values and weights. They share one factorisation, made at the first
  // question after a change. Huge where nothing holds a node, zero where it is fixed.

  /// Of geometry::boxplus of the pose, rotation first.
  [[nodiscard]] geometry::Mat6 covariance(Seq seq);
  /// Of all nodes, in the order of nodes().
  [[nodiscard]] std::vector<geometry::Mat6> covariances();
  /// Of two different nodes: a first. Of many pairs all of one b in a row: each new b costs a
  /// solution of the whole.
  [[nodiscard]] Eigen::Matrix<double, 12, 12> covariance(Seq a, Seq b);
  [[nodiscard]] LandmarkEstimate landmark(int number);
  [[nodiscard]] ScalarEstimate bias(int number);
  [[nodiscard]] ScalarEstimate tau(int number);
  /// What this range would read less what it read [m], at the present values.
  [[nodiscard]] double residual(const RangeFactor& factor) const;
  /// What this range would read, and how well that is known, all correlations included. The
  /// measured value is not used; the id may be new.
  [[nodiscard]] RangePrediction predict(const RangeFactor& factor);

  /// Judges each candidate against the graph without any loop, in the directions it claims
  /// (algorithms_fleet 8.4). The graph is solved without loops, from the present values; it keeps
  /// what it has. What lies in the settings' band is tried in the graph.
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
  mutable Window window_;  ///< mutable: where its columns are is found when it is asked
  mutable bool laid_out_ = false;
  StopFlag stop_;
  Seq next_ = 0;
  std::set<std::uint64_t> used_ranges_;
  std::unique_ptr<Marginals> marginals_;
};

}  // namespace rali::graph
