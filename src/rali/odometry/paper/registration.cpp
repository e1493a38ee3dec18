#include "rali/odometry/paper/registration.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "rali/geometry/so3.hpp"
#include "rali/odometry/paper/weights.hpp"

namespace rali::odometry::paper {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;
using geometry::Vec6;

namespace {

constexpr double kStopM = 1e-3;                               // algorithms.md 2.1
constexpr double kStopRad = 0.01 * std::numbers::pi / 180.0;  // algorithms.md 2.1
constexpr double kSigmaFloorM = 3e-3;  // lower bound of a point's distance sigma to its plane (2.3)
constexpr double kDampingMax = 1e6;    // of a step, in units of the prior hold_
constexpr std::size_t kBlock = 256;
constexpr double kFirm = 1e3;  // times the largest information: fixes the pose in this direction
constexpr double kSameDirection = 0.9;  // cosine
constexpr double kPivotMin = 1e-9;      // relative; less observable rotations are not adapted

Mat3 inverse_of_rotation(const Mat6& I) {
  const Eigen::SelfAdjointEigenSolver<Mat3> rotation(Mat3(I.topLeftCorner<3, 3>()));
  const Vec3& values = rotation.eigenvalues();
  const double minimum = kPivotMin * std::max(values.z(), 0.0);
  Vec3 inverse = Vec3::Zero();
  for (int k = 0; k < 3; ++k) inverse(k) = values(k) > minimum ? 1.0 / values(k) : 0.0;
  return rotation.eigenvectors() * inverse.asDiagonal() * rotation.eigenvectors().transpose();
}

}  // namespace

PlaneResidual plane_residual(const SE3& T_odom_body, const Vec3& p_body, const Vec3& q_odom,
                             const Vec3& n_odom) {
  PlaneResidual out;
  out.r_m = n_odom.dot(T_odom_body.R * p_body + T_odom_body.p - q_odom);
  // -n^T R [p]x = (p x R^T n)^T
  const Vec3 m = T_odom_body.R.transpose() * n_odom;
  out.J << p_body.y() * m.z() - p_body.z() * m.y(), p_body.z() * m.x() - p_body.x() * m.z(),
      p_body.x() * m.y() - p_body.y() * m.x(), n_odom;
  return out;
}

std::optional<Vec3> weakest_translation(const Mat6& I, const Vec3& near) {
  const Mat3 I_pr = I.bottomLeftCorner<3, 3>();
  const Mat3 I_t = I.bottomRightCorner<3, 3>() - I_pr * inverse_of_rotation(I) * I_pr.transpose();
  // Only directions in the horizontal plane spanned by `near` and `across` are candidates; the
  // vertical is weak too where few normals point up.
  const Vec3 up = Vec3::UnitZ();
  const Vec3 across = up.cross(near).normalized();
  Eigen::Matrix<double, 3, 2> B;
  B << near, across;
  const Eigen::Matrix2d flat = B.transpose() * I_t * B;
  if (!flat.allFinite()) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(flat);
  const Vec3 weakest = B * solver.eigenvectors().col(0);
  if (std::abs(weakest.dot(near)) < kSameDirection) return std::nullopt;
  return weakest;
}

void remove_translation(Mat6& I, Vec6& b, const Vec3& direction) {
  // The rotations coupled to the translation, chosen to lower its cost most.
  Vec6 u;
  u << -(inverse_of_rotation(I) * I.topRightCorner<3, 3>() * direction), direction;
  const Vec6 Iu = I * u;
  const double information = u.dot(Iu);
  if (!(information > 0.0)) return;
  b -= Iu * (u.dot(b) / information);
  I -= Iu * Iu.transpose() / information;
  I = (0.5 * (I + I.transpose())).eval();
}

void Registration::set_features(const PlanarFeatures& features, const SE3& T_body_lidar) {
  matches_.resize(features.size());
  ranges_m_.resize(features.size());
  for (std::size_t i = 0; i < features.size(); ++i) {
    Match& m = matches_[i];
    m.p_lidar = geometry::Vec3f(features.x_m[i], features.y_m[i], features.z_m[i]).cast<double>();
    m.p_body = T_body_lidar * m.p_lidar;
    m.n_body = T_body_lidar.R *
               geometry::Vec3f(features.nx[i], features.ny[i], features.nz[i]).cast<double>();
    ranges_m_[i] = m.p_lidar.norm();
  }
  const RangeQuartiles quartiles = range_quartiles(ranges_m_);
  q2_m_ = quartiles.q2_m;
  q3_m_ = quartiles.q3_m;
}

void Registration::match(const SE3& T, const SE3& T_body_lidar, bool turning, const Submap& map,
                         Executor& executor) {
  const RangeQuartiles quartiles{q2_m_, q3_m_};
  const geometry::Mat3 R_lidar_odom = (T.R * T_body_lidar.R).transpose();
  executor.for_blocks(
      matches_.size(), kBlock, [&](std::size_t /*index*/, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          Match& m = matches_[i];
          m.valid = map.plane_at(T * m.p_body, T.R * m.n_body, m.plane);
          if (!m.valid) continue;
          m.omega = multi_metric_weight(m.p_lidar, R_lidar_odom * m.plane.n_odom,
                                        m.plane.neighbours, turning, quartiles, settings_);
        }
      });
}

Registration::NormalEquations Registration::accumulate(const SE3& T) const {
  NormalEquations out;
  for (const Match& m : matches_) {
    if (!m.valid) continue;
    const PlaneResidual r = plane_residual(T, m.p_body, m.plane.centre_odom, m.plane.n_odom);
    const double w = irls_weight(m.omega, r.r_m, settings_);
    out.H.selfadjointView<Eigen::Lower>().rankUpdate(r.J, w);
    out.b += w * r.r_m * r.J;
    out.cost += robust_cost(m.omega, r.r_m, settings_);
    out.sum_w += w;
    out.sum_wr2 += w * r.r_m * r.r_m;
    ++out.matches;
  }
  out.H = Mat6(out.H.selfadjointView<Eigen::Lower>());
  return out;
}

double Registration::cost(const SE3& T) const {
  double sum = 0.0;
  for (const Match& m : matches_) {
    if (!m.valid) continue;
    const double r_m = m.plane.n_odom.dot(T * m.p_body - m.plane.centre_odom);
    sum += robust_cost(m.omega, r_m, settings_);
  }
  return sum;
}

// The damping is a prior at the initial guess with a small fraction of the information of the best
// constrained direction. Where matches are informative they dominate; where normals are only noise
// the guess does. It is about the guess, not the last iterate, because ten damped iterations would
// still reach the minimum of the matches.
void Registration::hold(const Mat6& H, const SE3& guess) {
  guess_ = guess;
  const double translation = H.diagonal().tail<3>().maxCoeff();
  hold_.setZero();
  hold_.diagonal().head<3>().setConstant(settings_.damping * H.diagonal().head<3>().maxCoeff());
  hold_.diagonal().tail<3>().setConstant(settings_.damping * translation);
  if (!degenerate_odom_) return;
  const std::optional<Vec3> axis = weakest_translation(H, *degenerate_odom_);
  if (!axis) return;
  hold_.bottomRightCorner<3, 3>() += kFirm * translation * *axis * axis->transpose();
}

double Registration::hold_cost(const SE3& T) const {
  const Vec6 d = geometry::boxminus(T, guess_);
  return 0.5 * d.dot(hold_ * d);
}

// One accepted step with fixed planes, or false.
bool Registration::step(const NormalEquations& equations, SE3& T, double& damping,
                        Vec6& taken) const {
  const Vec6 from_guess = geometry::boxminus(T, guess_);
  const Vec6 b = equations.b + hold_ * from_guess;
  const double cost_now = equations.cost + hold_cost(T);
  while (damping < kDampingMax) {
    const Mat6 H = equations.H + (1.0 + damping) * hold_;
    taken = -H.ldlt().solve(b);
    const SE3 moved = geometry::boxplus(T, taken);
    if (taken.allFinite() && cost(moved) + hold_cost(moved) <= cost_now) {
      T = moved;
      damping *= 0.1;
      return true;
    }
    damping = std::max(1.0, 10.0 * damping);
  }
  return false;
}

void Registration::finish(const NormalEquations& equations, RegistrationResult& out) {
  const double dof = std::max(1.0, static_cast<double>(equations.matches) - 6.0);
  const double floor = kSigmaFloorM * kSigmaFloorM * equations.sum_w;
  const double unit_variance = std::max(equations.sum_wr2, floor) / dof;
  out.matches = equations.matches;
  if (unit_variance <= 0.0) return;
  out.residual_rms_m = std::sqrt(equations.sum_wr2 / equations.sum_w);
  out.information = equations.H / unit_variance;
  // The minimum x with the prior solves H (x - x_matches) + D (x - guess) = 0.
  const Vec6 moved = geometry::boxminus(out.T_odom_body, guess_);
  out.pull = (equations.H * moved + hold_ * moved) / unit_variance;
  if (degenerate_odom_) {
    const auto axis = weakest_translation(out.information, *degenerate_odom_);
    if (axis) remove_translation(out.information, out.pull, *axis);
  }
  for (const Match& m : matches_) {
    if (!m.valid) continue;
    const double r_m = m.plane.n_odom.dot(out.T_odom_body * m.p_body - m.plane.centre_odom);
    const Vec3& n = m.plane.n_odom;
    evidence_.push_back({n, out.T_odom_body.R * m.p_body,
                         m.plane.normal_variance * (geometry::Mat3::Identity() - n * n.transpose()),
                         irls_weight(m.omega, r_m, settings_) / unit_variance, 1});
  }
}

RegistrationResult Registration::align(const PlanarFeatures& features, const SE3& T_body_lidar,
                                       const SE3& guess, bool turning, const Submap& map,
                                       Executor& executor) {
  RegistrationResult out;
  out.T_odom_body = guess;
  evidence_.clear();
  set_features(features, T_body_lidar);
  double damping = 0.0;
  NormalEquations equations;
  while (out.iterations < settings_.iterations_max && !out.converged) {
    match(out.T_odom_body, T_body_lidar, turning, map, executor);
    equations = accumulate(out.T_odom_body);
    if (equations.matches < settings_.matches_min) break;
    if (out.iterations == 0) hold(equations.H, guess);
    ++out.iterations;
    Vec6 taken = Vec6::Zero();
    // No step that lowers the cost: this is the minimum for these matches.
    const bool moved = step(equations, out.T_odom_body, damping, taken);
    out.converged =
        !moved || (taken.head<3>().norm() < kStopRad && taken.tail<3>().norm() < kStopM);
  }
  out.T_odom_body.R = geometry::so3_normalised(out.T_odom_body.R);
  out.matches = equations.matches;
  out.matched = equations.matches >= settings_.matches_min;
  if (out.matched) {
    finish(equations, out);
  } else {
    out.T_odom_body = guess;
  }
  return out;
}

}  // namespace rali::odometry::paper
