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
#include "rali/fleet/path/vehicle_path.hpp"
#include "rali/graph/global_graph.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::fleet {

/// A start pose measured by hand; vehicles by their place in the list of paths.
struct StartPrior {
  std::size_t relative_to = 0, path = 0;
  geometry::SE3 T_relative_path;  ///< between the first bodies' level frames
  double sigma_m = 0.2;
  double sigma_rad = 0.05;
};

/// All that vehicles of one group know of their paths, as one graph in the frame of the first:
/// increments of LiDAR and inertial data, ranges, start poses and loops, each fact once
/// (algorithms_fleet 8.1 to 8.3). Its nodes are those of the paths, one vehicle after the other.
class JointGraph {
 public:
  /// @param paths all of the fleet  @param T_map_odom of each; nothing: not of this group
  JointGraph(std::span<const VehiclePath> paths,
             std::vector<std::optional<geometry::SE3>> T_map_odom, const JointSettings& settings,
             const ranging::RangingSettings& ranging);

  void add(const StartPrior& prior);
  /// Those between vehicles of the group. @param bias_m of each pair where somebody measured it
  void add(const JointRanges& ranges, const std::vector<std::optional<double>>& bias_m);
  /// @param id its number among the candidates
  void add_loop(std::uint64_t id, const Loop& loop);

  /// Solves, judges each range anew, solves again.
  void solve();

  [[nodiscard]] geometry::SE3 T_map_body(std::size_t path, std::size_t node) const;
  /// Of geometry::boxplus. Relative to the map's origin; what the odometry's own map is wrong by is
  /// in it where the LiDAR sees.
  [[nodiscard]] geometry::Mat6 covariance(std::size_t path, std::size_t node);

  [[nodiscard]] graph::GlobalGraph& graph() { return *graph_; }

  [[nodiscard]] graph::Seq seq(std::size_t path, std::size_t node) const;
  [[nodiscard]] std::optional<graph::Seq> seq(KeyframeId keyframe) const;

  [[nodiscard]] std::vector<PairBias> biases();
  [[nodiscard]] std::vector<UsedRange> used_ranges();

 private:
  struct Range {
    graph::RangeFactor factor;
    std::size_t pair = 0;  ///< in pairs_
    double sigma_m = 0.1;  ///< without what neighbours have in common
    bool used = true;
  };

  [[nodiscard]] bool has_speed(graph::Seq seq) const;
  void add_path(std::size_t path);
  void add_steps(std::size_t path);
  void add_step(const VehiclePath::Node& before, const VehiclePath::Node& node, graph::Seq j);
  void add_start_of_inertial(graph::Seq seq);
  void add_tilt(std::size_t path);
  [[nodiscard]] std::vector<bool> inertial_nodes(const VehiclePath& path) const;
  [[nodiscard]] graph::RangeEnd end_of(std::size_t path, const RangeEnd& end) const;
  [[nodiscard]] geometry::Vec3 velocity_map(std::size_t path, const RangeEnd& end) const;
  [[nodiscard]] std::optional<std::size_t> keyframe_near(std::size_t path,
                                                         const graph::RangeEnd& end) const;
  void judge_again();

  std::span<const VehiclePath> paths_;
  std::vector<std::optional<geometry::SE3>> T_map_odom_;
  JointSettings settings_;
  ranging::RangingSettings ranging_;
  std::unique_ptr<graph::GlobalGraph> graph_;
  std::vector<std::size_t> first_;  ///< node of each path; the last one is the end
  std::vector<AntennaPair> pairs_;
  std::vector<Range> ranges_;  ///< by time
  std::uint64_t next_range_ = 0;
  std::vector<geometry::Mat6> covariances_;  ///< of all nodes, once asked for
};

}  // namespace rali::fleet
