#pragma once

#include <optional>
#include <vector>

#include "rali/eval/association.hpp"

namespace rali::eval {

/// Normalised estimation error squared e' P^-1 e with e = boxminus(truth, estimate); both poses in
/// the frame of the estimate, P as of geometry::boxplus. Expectation: 6 for a consistent
/// covariance. Empty if P is not positive definite or not finite.
[[nodiscard]] std::optional<double> nees_pose(const geometry::SE3& est, const geometry::SE3& truth,
                                              const geometry::Mat6& covariance);
/// The same for the position alone; expectation 3.
[[nodiscard]] std::optional<double> nees_position(const geometry::SE3& est,
                                                  const geometry::SE3& truth,
                                                  const geometry::Mat6& covariance);

/// NEES along one run. Poses of one run are correlated, so chi-square bounds of the mean do not
/// hold here; use the fraction inside the 95 % ellipsoid instead.
struct Consistency {
  std::size_t used = 0;
  std::size_t unusable = 0;  ///< covariances that are not positive definite
  double mean = 0.0;         ///< expectation: dof
  double median = 0.0;
  double fraction_within_95 = 0.0;  ///< expectation: 0.95
  int dof = 6;
};

/// @param covariances  one per estimate, indexed by PosePair::est_index
/// @param T_est_ref  maps the reference to the frame of the estimate, usually from the first pair
/// @param dof  6 for poses, 3 for positions
[[nodiscard]] Consistency consistency(const PairList& pairs,
                                      const std::vector<geometry::Mat6>& covariances,
                                      const geometry::SE3& T_est_ref, int dof);

/// 95 % bounds of the mean NEES of a consistent estimator over `runs` independent runs at one time:
/// chi2(0.025, runs dof)/runs and chi2(0.975, runs dof)/runs.
struct NeesBounds {
  double low, high;
};

[[nodiscard]] NeesBounds nees_bounds(int runs, int dof);

}  // namespace rali::eval
