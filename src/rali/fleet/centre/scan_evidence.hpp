#pragma once

#include <optional>
#include <span>
#include <vector>

#include "rali/fleet/centre/loop_search.hpp"
#include "rali/fleet/centre/path_frames.hpp"
#include "rali/fleet/frames/frame_solver.hpp"
#include "rali/fleet/path/vehicle_path.hpp"

namespace rali::fleet {

/// A node of a path, by their indices in the lists.
struct NodeOfPath {
  std::size_t path = 0, node = 0;
};

/// Nothing for a keyframe of no path.
[[nodiscard]] std::optional<NodeOfPath> node_of(std::span<const VehiclePath> paths,
                                                KeyframeId keyframe);

/// Evidence of a relative pose of two bodies on the frames of their paths, with where the bodies
/// are on their paths: the drift until then is not in its information.
/// @param information rotation in the source, translation in the target
[[nodiscard]] PoseEvidence evidence_between(std::span<const VehiclePath> paths,
                                            const NodeOfPath& target, const NodeOfPath& source,
                                            const geometry::SE3& T_target_source,
                                            const geometry::Mat6& information,
                                            const InitSettings& settings);

struct EvidenceKind {
  int group = 0;        ///< number of the alternatives
  bool tested = false;  ///< see PoseEvidence
};

/// Adds the evidence of a comparison of pieces of two paths on their frames: the placement without
/// rival, else each plausible one as an alternative, of which at most one is true. Adds nothing
/// between pieces of one path.
void add_scan_evidence(std::span<const VehiclePath> paths, std::span<const PathSubmap> submaps,
                       const LoopFound& found, const EvidenceKind& kind,
                       const InitSettings& settings, FrameSolver& solver);

/// Whether the result of a comparison without rival agrees with the frames.
[[nodiscard]] bool agrees(std::span<const VehiclePath> paths, std::span<const PathSubmap> submaps,
                          const LoopFound& found, const PathFrames& frames,
                          const InitSettings& settings);

/// The same of a loop.
[[nodiscard]] bool agrees(std::span<const VehiclePath> paths, const Loop& loop,
                          const PathFrames& frames, const InitSettings& settings);

/// Predicted transform of submaps of two paths from a start pose between the paths' first bodies,
/// with sigmas that grow by the distance travelled since.
[[nodiscard]] GuessOf guess_from_start(std::span<const VehiclePath> paths,
                                       std::span<const PathSubmap> submaps, std::size_t relative_to,
                                       std::size_t path, const geometry::SE3& T_relative_path,
                                       double sigma_m, double sigma_rad);

/// The same from a transform between the paths' levelled odom frames.
[[nodiscard]] GuessOf guess_from_frames(std::span<const VehiclePath> paths,
                                        std::span<const PathSubmap> submaps,
                                        std::size_t relative_to, std::size_t path,
                                        const YawPose& T_relative_path, double sigma_m,
                                        double sigma_rad);

/// Reduces the information of a comparison for the bend of a passage. Each metre it leaves
/// unconstrained, e.g. along a tunnel, allows an error of `bend_per_m` metres across it, and as
/// many radians. The direction at the other body, `apart_m` away, differs by that bend, too: a body
/// that slides along it moves across by as much more. Otherwise two comparisons whose unconstrained
/// directions differ by point noise would determine the position along them: as the intersection of
/// two lines that should be one.
/// @param information on (rotation, translation)  @param place_m2 position covariance without it
[[nodiscard]] geometry::Mat6 with_bend(const geometry::Mat6& information,
                                       const geometry::Mat3& place_m2, double bend_per_m,
                                       double apart_m);

/// A loop for the joint graph: between the bodies of the middle keyframes.
/// @param bend_per_m see with_bend()
[[nodiscard]] Loop loop_of(std::span<const PathSubmap> submaps, const LoopFound& found,
                           double bend_per_m);

/// The part of a shift along directions without information on (rotation, translation) [m]. A
/// comparison leaves these where the search happened to end.
[[nodiscard]] double slide_m(const geometry::Mat6& information, const geometry::Vec3& shift_m);

}  // namespace rali::fleet
