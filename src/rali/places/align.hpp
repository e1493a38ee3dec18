#pragma once

#include <array>
#include <optional>

#include "rali/degeneracy/information.hpp"
#include "rali/places/submap.hpp"

namespace rali::places {

/// Search range of align(), its robust weights and the errors its result must include.
struct AlignSettings {
  double start_sigma_m = 1.0;     ///< initial guess, horizontally and in height
  double start_sigma_deg = 10.0;  ///< initial yaw
  double level_sigma_deg = 0.5;   ///< roll and pitch: both frames are levelled
  double coarse_m = 2.0;          ///< widest gate of the first pass
  double middle_m = 0.6;
  int coarse_planes = 500;      ///< of the source, in the first pass
  int iterations = 12;          ///< per pass, at most
  double normal_deg = 30.0;     ///< normals of a pair differ by less
  double rough_sigma_m = 0.01;  ///< surfaces are not flat
  double cauchy_scale = 3.0;    ///< knee of the robust weight in sigma
  double gate_sigma = 4.0;      ///< pairs farther apart are rejected
  double gate_min_m = 0.06;
  double shared_sigma_m = 0.01;  ///< error common to all planes of a submap
  double shared_sigma_deg = 0.05;
  double shared_per_m = 0.001;  ///< per metre of a submap's path: its own drift
  degeneracy::AwareSettings aware = {
      .full_m = 0.05, .none_m = 0.2, .full_deg = 0.3, .none_deg = 1.0};

  template <class V>
  void visit(V& v) {
    v("start_sigma_m", start_sigma_m, 0.01, 10.0, "error of the start in metres");
    v("start_sigma_deg", start_sigma_deg, 0.1, 180.0, "error of the start's yaw");
    v("level_sigma_deg", level_sigma_deg, 0.01, 10.0, "error of the direction of gravity");
    v("coarse_m", coarse_m, 0.1, 10.0, "search radius of correspondences in the first pass");
    v("middle_m", middle_m, 0.05, 5.0, "and so far in the second");
    v("coarse_planes", coarse_planes, 20, 100000, "planes used in the first pass");
    v("iterations", iterations, 1, 100, "steps per pass at most");
    v("normal_deg", normal_deg, 1.0, 90.0, "normals of partners differ less");
    v("rough_sigma_m", rough_sigma_m, 0.0, 0.5, "roughness of surfaces");
    v("cauchy_scale", cauchy_scale, 0.5, 100.0, "knee of the robust weight, in sigma");
    v("gate_sigma", gate_sigma, 1.0, 20.0, "farther planes are no partners, in sigma");
    v("gate_min_m", gate_min_m, 0.0, 1.0, "the last gate is never narrower");
    v("shared_sigma_m", shared_sigma_m, 0.0, 1.0, "errors that all planes of a submap share");
    v("shared_sigma_deg", shared_sigma_deg, 0.0, 5.0, "the same in rotation");
    v("shared_per_m", shared_per_m, 0.0, 0.1, "drift within a submap per metre of its path");
    v.group("aware", aware, "which directions are observable");
  }
};

/// Relative pose of two submaps with the information that the planes support.
struct Registration {
  geometry::SE3 T_target_source;  ///< between the ref frames
  /// Of graph::RelativePoseFactor's residual: rotation in source, translation in target. Zero in
  /// directions that the planes do not constrain.
  geometry::Mat6 information = geometry::Mat6::Zero();
  double overlap = 0.0;  ///< fraction of the source's planes that have a partner
  double rms_m = 0.0;    ///< of partners' distances along the normal
  int matches = 0;
  bool converged = false;
  /// Axial (the least constrained horizontal), lateral, vertical; roll, pitch, yaw about them; in
  /// target. Sigma and category include the shared errors.
  std::array<degeneracy::DirectionInfo, 6> directions;

  [[nodiscard]] bool full_rank() const;
};

/// Registers the source to the target: point-to-plane between the planes of both, coarse to fine,
/// robust. A direction that no plane constrains keeps its start value and gets no information.
/// Errors of planes are counted once per plane, errors common to a submap once (algorithms 2.4,
/// 3.2; algorithms_fleet 8.2).
/// @param open translation (unit, target frame) that the planes must not constrain, with the turn
/// that goes with it in a bend; it keeps its start value, too
[[nodiscard]] Registration align(const Submap& target, const Submap& source,
                                 const geometry::SE3& T_target_source_start,
                                 const AlignSettings& settings,
                                 const std::optional<geometry::Vec3>& open = {});

/// The same relation between the bodies of the two middle scans, as a pose graph needs it.
struct BodyRelation {
  geometry::SE3 T_target_source;
  geometry::Mat6 information = geometry::Mat6::Zero();
};

[[nodiscard]] BodyRelation between_bodies(const Registration& registration, const Submap& target,
                                          const Submap& source);

}  // namespace rali::places
