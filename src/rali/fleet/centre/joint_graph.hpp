#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "rali/fleet/centre/estimate.hpp"
#include "rali/fleet/centre/joint_ranges.hpp"
#include "rali/fleet/centre/settings.hpp"
#include "rali/fleet/messages/boundary.hpp"
#include "rali/fleet/path/vehicle_path.hpp"
#include "rali/graph/pose_graph.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::fleet {

/// A start pose measured by hand; vehicles by their place in the list of paths.
struct StartPrior {
  std::size_t relative_to = 0, path = 0;
  geometry::SE3 T_relative_path;  ///< between the first bodies' level frames
  double sigma_m = 0.2;
  double sigma_rad = 0.05;
};

/// What ties the nodes of a path where its LiDAR is blind.
enum class BlindSteps {
  kInertial,  ///< inertial data, to be weighed against ranges
  /// The filter's own path. Without ranges in the group nothing knows more: the filter has seen
  /// weak structure, what vehicles can do, and radios whose place nobody knows.
  kFilter
};

/// All that vehicles of one group know of their paths, as one graph in the frame of the first:
/// increments of LiDAR and inertial data, ranges, start poses and loops, each fact once
/// (algorithms_fleet 8.1 to 8.3). Its nodes are those of the paths, one vehicle after the other;
/// from a boundary on, if there is one: then what only earlier nodes have to do with is in the
/// boundary.
class JointGraph {
 public:
  /// @param paths all of the fleet  @param T_map_odom of each; nothing: not of this group
  /// @param before of this group; null: from the begin. Must outlive the object.
  JointGraph(std::span<const VehiclePath> paths,
             std::vector<std::optional<geometry::SE3>> T_map_odom, const JointSettings& settings,
             const ranging::RangingSettings& ranging, const RoundBoundary* before = nullptr,
             BlindSteps blind_steps = BlindSteps::kInertial);

  /// Whether a graph of these paths can go on from a boundary: all its nodes are there, and its
  /// numbers are numbers.
  [[nodiscard]] static bool fits(const RoundBoundary& boundary, std::span<const VehiclePath> paths,
                                 const JointSettings& settings);

  void add(const StartPrior& prior);
  /// Those between vehicles of the group; to be called once. Ranges of nodes before the boundary
  /// only tell how much the next ones may count. @param bias_m of each pair where somebody measured
  /// it
  void add(const JointRanges& ranges, const std::vector<std::optional<double>>& bias_m);
  /// @param id its number among the candidates
  void add_loop(std::uint64_t id, const Loop& loop);

  /// Where the flag is raised, solve() ends early.
  void stop_on(StopFlag stop);

  /// Solves, judges each range anew, solves again.
  void solve();

  /// What all that is known says about the nodes at a time and later. The graph stays as it is.
  [[nodiscard]] RoundBoundary boundary(Time until);

  /// Index of the first node of a path that is in the graph.
  [[nodiscard]] std::size_t begin(std::size_t path) const { return begin_[path]; }

  [[nodiscard]] geometry::SE3 T_map_body(std::size_t path, std::size_t node) const;
  /// Of geometry::boxplus. Relative to the map's origin; what the odometry's own map is wrong by is
  /// in it where the LiDAR sees.
  [[nodiscard]] geometry::Mat6 covariance(std::size_t path, std::size_t node);

  [[nodiscard]] graph::PoseGraph& graph() { return *graph_; }

  [[nodiscard]] graph::Seq seq(std::size_t path, std::size_t node) const;
  /// Nothing for one before the boundary.
  [[nodiscard]] std::optional<graph::Seq> seq(KeyframeId keyframe) const;

  [[nodiscard]] std::vector<PairBias> biases();
  [[nodiscard]] std::vector<UsedRange> used_ranges();

 private:
  struct Range {
    graph::RangeFactor factor;
    std::size_t pair = 0;     ///< in pairs_
    double sigma_m = 0.1;     ///< without what neighbours have in common
    std::size_t stretch = 0;  ///< ranges of the same one may all be off by the same
    bool used = true;
    double doubt = 1.0;  ///< of its stretch: factor on the sigma in the graph
  };

  struct PathNode {
    std::size_t path = 0, node = 0;
  };

  [[nodiscard]] bool has_speed(graph::Seq seq) const;
  [[nodiscard]] PathNode path_node(graph::Seq seq) const;
  [[nodiscard]] bool any_blind() const;
  [[nodiscard]] bool is_open(std::size_t path, std::size_t node) const;
  void count_ranges(std::size_t pair, const graph::PoseGraph& left, BoundaryBias& count) const;
  [[nodiscard]] const BoundaryBias* known_before(std::size_t pair) const;
  void add_pairs_before();
  void take_boundary();
  void add_path(std::size_t path);
  void add_steps(std::size_t path);
  void add_start_of_inertial(graph::Seq seq);
  void add_tilt(std::size_t path);
  [[nodiscard]] std::vector<bool> inertial_nodes(std::size_t path) const;
  [[nodiscard]] graph::RangeEnd end_of(std::size_t path, const RangeEnd& end) const;
  [[nodiscard]] geometry::Vec3 velocity_map(std::size_t path, const RangeEnd& end) const;
  [[nodiscard]] std::optional<std::size_t> keyframe_near(std::size_t path,
                                                         const graph::RangeEnd& end) const;
  void judge_again();
  void weigh_stretches();

  std::span<const VehiclePath> paths_;
  std::vector<std::optional<geometry::SE3>> T_map_odom_;
  JointSettings settings_;
  ranging::RangingSettings ranging_;
  const RoundBoundary* before_ = nullptr;
  BlindSteps blind_steps_ = BlindSteps::kInertial;
  StopFlag stop_;
  std::unique_ptr<graph::PoseGraph> graph_;
  std::vector<std::size_t> begin_;  ///< index of the first node of each path
  std::vector<std::size_t> first_;  ///< its number in the graph; the last one is the end
  std::vector<AntennaPair> pairs_;
  std::vector<Range> ranges_;  ///< by time
  std::size_t stretches_ = 0;
  std::uint64_t next_range_ = 0;
  std::vector<geometry::Mat6> covariances_;         ///< of all nodes, once asked for
  std::vector<std::vector<geometry::Mat6>> steps_;  ///< shape_covariances() of each path
};

}  // namespace rali::fleet
