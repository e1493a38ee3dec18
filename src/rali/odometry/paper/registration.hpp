#pragma once

#include <optional>
#include <span>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/degeneracy/evidence.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/odometry/paper/planar_features.hpp"
#include "rali/odometry/paper/settings.hpp"
#include "rali/odometry/paper/submap.hpp"

namespace rali::odometry::paper {

/// Distance of a point to a plane and its derivative by geometry::boxplus.
struct PlaneResidual {
  double r_m = 0.0;
  geometry::Vec6 J = geometry::Vec6::Zero();
};

/// r = n . (R p_body + p - q); dr/dtheta = -n^T R [p_body]x, dr/dp = n^T. Source: algorithms 2.3.
[[nodiscard]] PlaneResidual plane_residual(const geometry::SE3& T_odom_body,
                                           const geometry::Vec3& p_body,
                                           const geometry::Vec3& q_odom,
                                           const geometry::Vec3& n_odom);

/// The horizontal direction of translation with the least information in a Gauss-Newton system,
/// rotations left free; nothing if it is more than 25 degrees off `near` (unit, horizontal, in
/// odom).
[[nodiscard]] std::optional<geometry::Vec3> weakest_translation(const geometry::Mat6& I,
                                                                const geometry::Vec3& near);

/// Removes the information of a Gauss-Newton system on a translation. Afterwards the system is
/// unconstrained along `direction` with the coupled rotations. Directions that are I-orthogonal to
/// it are unchanged; I stays positive semidefinite. Source: algorithms 2.4, with J = 0.
/// @param I,b boxplus order; @param direction unit, in odom
void remove_translation(geometry::Mat6& I, geometry::Vec6& b, const geometry::Vec3& direction);

struct RegistrationResult {
  geometry::SE3 T_odom_body;
  bool matched = false;    ///< false: too few matches, T_odom_body is the guess
  bool converged = false;  ///< last step below 1 mm and 0.01 deg
  int matches = 0;
  int iterations = 0;
  double residual_rms_m = 0.0;  ///< weighted
  /// Weighted Hessian divided by the variance of unit weight; boxplus order.
  geometry::Mat6 information = geometry::Mat6::Zero();
  /// information * (minimum of the matches alone [-] guess): the effect of the prior is removed.
  geometry::Vec6 pull = geometry::Vec6::Zero();
};

/// Scan-to-map registration with the multi-metric weights, by Levenberg-Marquardt.
/// Source: paper, section "Scan-to-Map Matching with Multi-Metric Weights".
class Registration {
 public:
  explicit Registration(const PaperSettings& settings) : settings_(settings) {}

  /// The next align() keeps the pose at its guess along the degenerate direction (horizontal, unit,
  /// in odom) and returns no information along it. Normals give this direction to about a degree,
  /// but a degree off it the walls constrain the pose. Hence the weakest direction of the matches
  /// near it is used.
  void hold_along(const std::optional<geometry::Vec3>& direction_odom) {
    degenerate_odom_ = direction_odom;
  }

  /// @param features in the LiDAR frame at the time of the pose to estimate
  /// @param guess initial pose; along directions that no match constrains it is kept
  /// @param turning the kinematic weight is on
  RegistrationResult align(const PlanarFeatures& features, const geometry::SE3& T_body_lidar,
                           const geometry::SE3& guess, bool turning, const Submap& map,
                           Executor& executor);

  /// One entry per match of the last call; matches with overlapping planes are not independent.
  [[nodiscard]] std::span<const degeneracy::PlaneEvidence> evidence() const { return evidence_; }

 private:
  struct Match {
    geometry::Vec3 p_lidar, p_body, n_body;
    LocalPlane plane;
    double omega = 0.0;
    bool valid = false;
  };

  struct NormalEquations {
    geometry::Mat6 H = geometry::Mat6::Zero();
    geometry::Vec6 b = geometry::Vec6::Zero();
    double cost = 0.0;
    double sum_w = 0.0;
    double sum_wr2 = 0.0;
    int matches = 0;
  };

  void set_features(const PlanarFeatures& features, const geometry::SE3& T_body_lidar);
  void match(const geometry::SE3& T, const geometry::SE3& T_body_lidar, bool turning,
             const Submap& map, Executor& executor);
  [[nodiscard]] NormalEquations accumulate(const geometry::SE3& T) const;
  [[nodiscard]] double cost(const geometry::SE3& T) const;
  void hold(const geometry::Mat6& H, const geometry::SE3& guess);
  [[nodiscard]] double hold_cost(const geometry::SE3& T) const;
  [[nodiscard]] bool step(const NormalEquations& equations, geometry::SE3& T, double& damping,
                          geometry::Vec6& taken) const;
  void finish(const NormalEquations& equations, RegistrationResult& out);

  PaperSettings settings_;
  std::vector<Match> matches_;
  std::vector<double> ranges_m_;
  double q2_m_ = 0.0;
  double q3_m_ = 0.0;
  geometry::SE3 guess_;
  geometry::Mat6 hold_ = geometry::Mat6::Zero();  ///< information of the prior at the guess
  std::optional<geometry::Vec3> degenerate_odom_;
  std::vector<degeneracy::PlaneEvidence> evidence_;
};

}  // namespace rali::odometry::paper
