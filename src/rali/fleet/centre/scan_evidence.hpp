#pragma once

#include <optional>
#include <span>
#include <vector>

#include "rali/fleet/centre/loop_search.hpp"
#include "rali/fleet/centre/path_frames.hpp"
#include "rali/fleet/frames/frame_solver.hpp"
#include "rali/fleet/path/vehicle_path.hpp"

namespace rali::fleet {

/// A node of a path, by their places in the lists.
struct NodeOfPath {
  std::size_t path = 0, node = 0;
};

/// Nothing for a keyframe that no path has.
[[nodiscard]] std::optional<NodeOfPath> node_of(std::span<const VehiclePath> paths,
                                                KeyframeId keyframe);

/// What a relative pose of two bodies says about the frames of their paths. What the paths may have
/// drifted by then is part of its uncertainty.
/// @param information rotation in the source, translation in the target
[[nodiscard]] PoseEvidence evidence_between(std::span<const VehiclePath> paths,
                                            const NodeOfPath& target, const NodeOfPath& source,
                                            const geometry::SE3& T_target_source,
                                            const geometry::Mat6& information,
                                            const InitSettings& settings);

/// What a comparison of pieces of two paths says about their frames: the placement
/// that stands alone, else each believable one as an alternative, of which at most one holds. What
/// the paths may have drifted by then is part of its doubt. Nothing between pieces of one path.
/// @param group number of the alternatives, never used before
void add_scan_evidence(std::span<const VehiclePath> paths, std::span<const PathSubmap> submaps,
                       const LoopFound& found, int group, const InitSettings& settings,
                       FrameSolver& solver);

/// Whether what a comparison found without rival is where the frames have it, too.
[[nodiscard]] bool agrees(std::span<const VehiclePath> paths, std::span<const PathSubmap> submaps,
                          const LoopFound& found, const PathFrames& frames,
                          const InitSettings& settings);

/// The same of a loop.
[[nodiscard]] bool agrees(std::span<const VehiclePath> paths, const Loop& loop,
                          const PathFrames& frames, const InitSettings& settings);

/// How submaps of two paths lie to each other if the bodies of the paths' first nodes do so, with
/// sigmas that grow by the way driven since.
[[nodiscard]] GuessOf guess_from_start(std::span<const VehiclePath> paths,
                                       std::span<const PathSubmap> submaps, std::size_t relative_to,
                                       std::size_t path, const geometry::SE3& T_relative_path,
                                       double sigma_m, double sigma_rad);

/// What a comparison says if the passage turns: what it leaves open, say a metre along a tunnel,
/// takes `bend_per_m` metres with it across, and as many radians. Otherwise two comparisons whose
/// open directions differ by the noise of their points would tell the place along them: the
/// crossing of two lines that should be one.
/// @param information on (rotation, translation)  @param place_m2 what is known without it
[[nodiscard]] geometry::Mat6 with_bend(const geometry::Mat6& information,
                                       const geometry::Mat3& place_m2, double bend_per_m);

/// A loop for the joint graph: between the bodies of the middle keyframes.
/// @param bend_per_m see with_bend()
[[nodiscard]] Loop loop_of(std::span<const PathSubmap> submaps, const LoopFound& found,
                           double bend_per_m);

/// How much of a shift leads along directions of which an information on (rotation, translation)
/// says nothing [m]. A comparison leaves these where the search happened to end.
[[nodiscard]] double slide_m(const geometry::Mat6& information, const geometry::Vec3& shift_m);

}  // namespace rali::fleet
