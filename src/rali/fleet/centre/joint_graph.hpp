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
#include "rali/fleet/messages/separator_prior.hpp"
#include "rali/fleet/path/shape.hpp"
#include "rali/fleet/path/vehicle_path.hpp"
#include "rali/graph/pose_graph.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::fleet {

/// A start pose measured by hand; vehicles by their index in the list of paths.
struct StartPrior {
  std::size_t relative_to = 0, path = 0;
  geometry::SE3 T_relative_path;  ///< between the first bodies' level frames
  double sigma_m = 0.2;
  double sigma_rad = 0.05;
};

/// Constraint between nodes of a path where its LiDAR is degenerate.
enum class DegenerateSteps {
  kInertial,  ///< inertial data, weighted against ranges
  /// The filter's own path. Without ranges in the group no other source is better: the filter has
  /// used weak structure, motion limits of vehicles, and radios at unknown positions.
  kFilter
};

/// Of roll and pitch by gravity: as an odometry states it, and what no odometry states.
[[nodiscard]] double level_sigma_rad(double stated_rad, const JointSettings& settings);
/// Of a path's odom at a node, with gravity or without.
[[nodiscard]] double level_sigma_rad(const Increment& step, const JointSettings& settings);

/// All measurements of one group's paths as one graph in the frame of the first path: increments of
/// LiDAR and inertial data, ranges, start poses and loops, each fact once (algorithms_fleet 8.1 to
/// 8.3). Its nodes are those of the paths, one vehicle after the other. With a separator prior they
/// begin at the separator: the prior contains all terms that involve only earlier nodes.
class JointGraph {
 public:
  /// @param paths all of the fleet  @param T_map_odom of each; nothing: not of this group
  /// @param before of this group; null: from the start. Must outlive the object.
  JointGraph(std::span<const VehiclePath> paths,
             std::vector<std::optional<geometry::SE3>> T_map_odom, const JointSettings& settings,
             const ranging::RangingSettings& ranging, const SeparatorPrior* before = nullptr,
             DegenerateSteps degenerate_steps = DegenerateSteps::kInertial);

  /// Whether a graph of these paths can continue from a separator prior: all its nodes exist, and
  /// its values are valid numbers.
  [[nodiscard]] static bool fits(const SeparatorPrior& separator,
                                 std::span<const VehiclePath> paths, const JointSettings& settings);

  void add(const StartPrior& prior);
  /// Those between vehicles of the group; to be called once. Ranges before the separator only set
  /// the weight of those after it. @param bias_m of each pair where it was measured
  void add(const JointRanges& ranges, const std::vector<std::optional<double>>& bias_m);
  /// @param id its number among the candidates
  void add_loop(std::uint64_t id, const Loop& loop);

  /// If the flag is raised, solve() ends early.
  void stop_on(StopFlag stop);

  /// Solves, classifies each range again, solves again.
  void solve();

  /// Information of all known data on the nodes at a time and later. The graph is not changed.
  [[nodiscard]] SeparatorPrior separator(Time until);

  /// Index of the first node of a path that is in the graph.
  [[nodiscard]] std::size_t begin(std::size_t path) const { return begin_[path]; }

  [[nodiscard]] geometry::SE3 T_map_body(std::size_t path, std::size_t node) const;
  /// Of geometry::boxplus. Relative to the map's origin and heading, which are those of the first
  /// node, and to its level, which is that of the vehicle that knows it best, at its first node in
  /// the graph. Includes the error of the odometry's own map in observable directions.
  [[nodiscard]] geometry::Mat6 covariance(std::size_t path, std::size_t node);

  [[nodiscard]] graph::PoseGraph& graph() { return *graph_; }

  [[nodiscard]] graph::Seq seq(std::size_t path, std::size_t node) const;
  /// Nothing for one before the separator.
  [[nodiscard]] std::optional<graph::Seq> seq(KeyframeId keyframe) const;

  [[nodiscard]] std::vector<PairBias> biases();
  [[nodiscard]] std::vector<UsedRange> used_ranges();

 private:
  struct Range {
    graph::RangeFactor factor;
    std::size_t pair = 0;     ///< in pairs_
    double sigma_m = 0.1;     ///< without the error shared with neighbours
    std::size_t stretch = 0;  ///< ranges with the same index may share an error
    bool excess = false;      ///< longer than the line of sight, by the ranges around it
    bool used = true;
    double uncertainty = 1.0;  ///< of its stretch: factor on the sigma in the graph
  };

  struct PathNode {
    std::size_t path = 0, node = 0;
  };

  [[nodiscard]] bool has_speed(graph::Seq seq) const;
  [[nodiscard]] PathNode path_node(graph::Seq seq) const;
  [[nodiscard]] bool any_degenerate() const;
  [[nodiscard]] bool is_open(std::size_t path, std::size_t node) const;
  void count_ranges(std::size_t pair, const graph::PoseGraph& left, SeparatorBias& count) const;
  [[nodiscard]] const SeparatorBias* known_before(std::size_t pair) const;
  void add_pairs_before();
  void take_separator_prior();
  void add_path(std::size_t path);
  void add_steps(std::size_t path);
  void add_standstill(std::size_t path);
  [[nodiscard]] std::size_t first_levelled(std::size_t path) const;
  void add_initialised(std::size_t path);
  [[nodiscard]] std::optional<std::size_t> known_before(std::size_t path, std::size_t node,
                                                        const Regained& found) const;
  void add_regained(std::size_t path, std::size_t node, graph::RelativePoseFactor& shape);
  void add_start_of_inertial(std::size_t path, std::size_t node);
  void add_tilt(std::size_t path);
  void hold_map(graph::Seq seq, const geometry::SE3& T_map_body);
  [[nodiscard]] std::optional<graph::Seq> level_reference() const;
  [[nodiscard]] std::vector<geometry::Mat6> covariances_in_map() const;
  [[nodiscard]] std::vector<bool> inertial_nodes(std::size_t path) const;
  [[nodiscard]] graph::RangeEnd end_of(std::size_t path, const RangeEnd& end) const;
  [[nodiscard]] geometry::Vec3 velocity_map(std::size_t path, const RangeEnd& end) const;
  [[nodiscard]] std::optional<std::size_t> keyframe_near(std::size_t path,
                                                         const graph::RangeEnd& end) const;
  void reclassify_outliers();
  void weigh_stretches();

  std::span<const VehiclePath> paths_;
  std::vector<std::optional<geometry::SE3>> T_map_odom_;
  JointSettings settings_;
  ranging::RangingSettings ranging_;
  const SeparatorPrior* before_ = nullptr;
  DegenerateSteps degenerate_steps_ = DegenerateSteps::kInertial;
  StopFlag stop_;
  std::unique_ptr<graph::PoseGraph> graph_;
  std::vector<std::size_t> begin_;  ///< index of the first node of each path
  std::vector<std::size_t> first_;  ///< its number in the graph; the last one is the end
  std::vector<AntennaPair> pairs_;
  std::vector<Range> ranges_;            ///< by time
  std::optional<graph::Seq> holds_map_;  ///< the node that fixes the map's origin and heading
  std::size_t stretches_ = 0;
  std::uint64_t next_range_ = 0;
  std::vector<geometry::Mat6> covariances_;         ///< of all nodes, once computed
  std::vector<std::vector<geometry::Mat6>> steps_;  ///< shape_covariances() of each path
};

}  // namespace rali::fleet
