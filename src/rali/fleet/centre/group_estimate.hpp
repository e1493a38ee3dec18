#pragma once

#include <optional>
#include <span>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/base/stop_flag.hpp"
#include "rali/fleet/centre/estimate.hpp"
#include "rali/fleet/centre/fleet_settings.hpp"
#include "rali/fleet/centre/joint_graph.hpp"
#include "rali/fleet/centre/loop_memory.hpp"
#include "rali/fleet/centre/path_frames.hpp"

namespace rali::fleet {

/// All known data of a fleet when its groups are solved.
struct GroupInput {
  std::span<const VehiclePath> paths;
  std::span<const PathSubmap> submaps;
  const PathFrames& frames;
  const JointRanges& ranges;
  const std::vector<StartPrior>& starts;
  std::vector<std::optional<double>> bias_m;  ///< per pair of antennas, where measured
  const FleetSettings& settings;
  /// Comparisons that agree with the frames; of this solution.
  std::span<const Loop> seen = {};
  const SeparatorPrior* before = nullptr;  ///< of this group: nodes before it are not solved for
  LoopMemory* memory = nullptr;            ///< of earlier solutions; this one adds to it
  StopFlag stop = {};                      ///< if it is raised, the result is invalid
};

/// Solves for the paths of one group, searches places that its vehicles saw twice, solves again,
/// and adds the result. A single vehicle is left unchanged unless a loop was closed.
/// @return for each of `ends`, the separator prior of all facts on the nodes from then on
std::vector<SeparatorPrior> estimate_group(const GroupInput& input, std::size_t group,
                                           Executor& executor, FleetEstimate& out,
                                           std::span<const Time> ends = {});

/// Of (R_i^T R_j, R_i^T (p_j - p_i)): rotation in j, translation in i, from the joint covariance of
/// both poses (algorithms_fleet 8.1).
[[nodiscard]] geometry::Mat6 relative_covariance(const geometry::SE3& T_i, const geometry::SE3& T_j,
                                                 const Eigen::Matrix<double, 12, 12>& joint);

/// Predicted transform between two submaps, by the poses of their middles and the covariance of
/// relative_covariance().
[[nodiscard]] places::Guess guess_of(const PathSubmap& target, const PathSubmap& source,
                                     const geometry::SE3& T_map_target,
                                     const geometry::SE3& T_map_source, const geometry::Mat6& P);

}  // namespace rali::fleet
