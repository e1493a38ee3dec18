#include "rali/eval/consistency.hpp"

#include <cmath>

#include <Eigen/Cholesky>

#include "rali/eval/statistics.hpp"

namespace rali::eval {

using geometry::Mat6;
using geometry::SE3;

namespace {

template <class Matrix, class Vector>
std::optional<double> quadratic_form(const Matrix& P, const Vector& e) {
  if (!P.allFinite() || !e.allFinite()) return std::nullopt;
  const Eigen::LLT<Matrix> factor(P);
  if (factor.info() != Eigen::Success) return std::nullopt;
  const double value = e.dot(factor.solve(e));
  return std::isfinite(value) ? std::optional<double>(value) : std::nullopt;
}

}  // namespace

std::optional<double> nees_pose(const SE3& est, const SE3& truth, const Mat6& covariance) {
  const geometry::Vec6 e = geometry::boxminus(truth, est);
  return quadratic_form(covariance, e);
}

std::optional<double> nees_position(const SE3& est, const SE3& truth, const Mat6& covariance) {
  const geometry::Mat3 P = covariance.bottomRightCorner<3, 3>();
  const geometry::Vec3 e = truth.p - est.p;
  return quadratic_form(P, e);
}

Consistency consistency(const PairList& pairs, const std::vector<Mat6>& covariances,
                        const SE3& T_est_ref, int dof) {
  Consistency out;
  out.dof = dof;
  const double gate = chi2_quantile(0.95, dof);
  std::vector<double> values;
  std::size_t within = 0;
  for (const PosePair& p : pairs) {
    if (p.est_index >= covariances.size()) {
      ++out.unusable;
      continue;
    }
    const SE3 truth = T_est_ref * p.ref;
    const auto value = dof == 3 ? nees_position(p.est, truth, covariances[p.est_index])
                                : nees_pose(p.est, truth, covariances[p.est_index]);
    if (!value) {
      ++out.unusable;
      continue;
    }
    values.push_back(*value);
    if (*value <= gate) ++within;
  }
  out.used = values.size();
  if (values.empty()) return out;
  out.fraction_within_95 = static_cast<double>(within) / static_cast<double>(out.used);
  const Statistics s = statistics(std::move(values));
  out.mean = s.mean;
  out.median = s.median;
  return out;
}

NeesBounds nees_bounds(int runs, int dof) {
  const double n = static_cast<double>(runs);
  return {chi2_quantile(0.025, runs * dof) / n, chi2_quantile(0.975, runs * dof) / n};
}

}  // namespace rali::eval
