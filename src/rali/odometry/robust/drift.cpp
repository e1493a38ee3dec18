#include "rali/odometry/robust/drift.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Eigenvalues>

namespace rali::odometry {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;
using geometry::Vec6;

namespace {

/// Height of a LiDAR above the body, and the distance at which 16 rings of a low LiDAR see the
/// floor ahead.
constexpr double kAbove_m = 0.5, kAhead_m = 3.0;

/// Variances far below any real uncertainty [m^2, rad^2].
constexpr double kNothing = 1e-18;

double squared_rad(double angle_deg) { return std::pow(angle_deg * std::numbers::pi / 180.0, 2); }

/// Left perturbation for a boxplus error: phi = R theta, rho = dp + p x phi.
Mat6 left_from_boxplus(const SE3& T) {
  Mat6 A = Mat6::Zero();
  A.block<3, 3>(0, 0) = T.R;
  A.block<3, 3>(3, 0) = geometry::skew(T.p) * T.R;
  A.block<3, 3>(3, 3).setIdentity();
  return A;
}

Mat6 boxplus_from_left(const SE3& T) {
  Mat6 A = Mat6::Zero();
  A.block<3, 3>(0, 0) = T.R.transpose();
  A.block<3, 3>(3, 0) = -geometry::skew(T.p);
  A.block<3, 3>(3, 3).setIdentity();
  return A;
}

/// V f(x) V^T.
template <class F>
Mat6 of_eigenvalues(const Eigen::SelfAdjointEigenSolver<Mat6>& solver, F&& f) {
  Vec6 values;
  for (int k = 0; k < 6; ++k) values[k] = f(solver.eigenvalues()[k]);
  return solver.eigenvectors() * values.asDiagonal() * solver.eigenvectors().transpose();
}

}  // namespace

MapFollowing MapFollowing::all() { return {Mat6::Identity(), Mat6::Zero()}; }

MapFollowing MapFollowing::nothing() { return {Mat6::Zero(), Mat6::Identity()}; }

/// Scaled by the prediction's own sigmas the gain is symmetric, and so are its roots.
MapFollowing MapFollowing::of(const Mat6& P_predicted, const Mat6& information) {
  const auto sigma = [](double x) { return std::sqrt(std::max(x, kNothing)); };
  const Eigen::SelfAdjointEigenSolver<Mat6> of_P(P_predicted);
  const Mat6 root = of_eigenvalues(of_P, sigma);
  const Mat6 inverse = of_eigenvalues(of_P, [&](double x) { return 1.0 / sigma(x); });
  const Eigen::SelfAdjointEigenSolver<Mat6> scaled(Mat6(root * information * root));
  const auto gain = [](double x) { return std::max(x, 0.0) / (1.0 + std::max(x, 0.0)); };
  return {
      root * of_eigenvalues(scaled, [&](double x) { return std::sqrt(gain(x)); }) * inverse,
      root * of_eigenvalues(scaled, [&](double x) { return std::sqrt(1.0 - gain(x)); }) * inverse};
}

Drift::Drift(const DriftSettings& settings, bool levelled)
    : settings_(settings),
      D_(1, Mat6::Zero()),
      begun_odom_m_(1, Vec3::Zero()),
      middle_odom_m_(1, Vec3::Zero()) {
  // Sparse rings observe pitch and roll poorly at standstill: the map grows in a frame that is
  // rotated against the first pose by about this much.
  const double tilt =
      squared_rad(levelled ? settings.start_tilt_deg : settings.start_tilt_free_deg);
  D_[0].diagonal() << tilt, tilt, squared_rad(settings.start_sigma_deg), Vec3::Zero();
  // The rotation is not about the body: the LiDAR is above it, and the floor is seen ahead of it.
  const Vec3 lever_m(kAbove_m, kAbove_m, kAhead_m);
  D_[0].diagonal().tail<3>() =
      (tilt * lever_m.cwiseAbs2()).array() + settings.start_sigma_m * settings.start_sigma_m;
  carried_ = D_[0];
}

namespace {

/// Value of a generation, interpolated between two.
template <class M>
M between(const std::vector<M>& of, double epoch) {
  const double at = std::clamp(epoch, 0.0, static_cast<double>(of.size() - 1));
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, of.size() - 1);
  const double f = at - static_cast<double>(below);
  return (1.0 - f) * of[below] + f * of[above];
}

}  // namespace

Mat6 Drift::error_at(double epoch) const { return between(D_, epoch); }

/// Error of a pose (boxplus) that is registered with planes of `mean_epoch`. A tilt that grew
/// evenly along a path rotates its end about the mean position of the path.
Vec6 Drift::bent(const SE3& T_odom_body, double mean_epoch, const Level& level) const {
  const Vec3 turn(level.tilt_rad.x(), level.tilt_rad.y(), 0.0);
  Vec6 out;
  out.head<3>() = T_odom_body.R.transpose() * turn;
  out.tail<3>() = turn.cross(T_odom_body.p - between(middle_odom_m_, mean_epoch));
  return out;
}

/// Whether the pose is much less certain than the newest planes, whatever the estimated distance:
/// in a degenerate stretch the estimate may not move for seconds although the vehicle drives.
bool Drift::has_grown(const Mat6& newest, const Mat6& now) {
  constexpr double kFactor = 2.0;     // of variances
  constexpr double kMin_m2 = 2.5e-3;  // 5 cm
  const auto maximum = [](const Mat6& P) {
    return Eigen::SelfAdjointEigenSolver<Mat3>(Mat3(P.bottomRightCorner<3, 3>()),
                                               Eigen::EigenvaluesOnly)
        .eigenvalues()[2];
  };
  return maximum(now) > kFactor * maximum(newest) + kMin_m2;
}

Mat6 Drift::update(const SE3& T_odom_body, double mean_epoch, const Mat6& P_local,
                   const MapFollowing& following, const std::optional<Level>& level,
                   std::span<const HeldAlong> held, const Mat6& turned) {
  const Mat6 A = left_from_boxplus(T_odom_body);
  const Mat6 B = boxplus_from_left(T_odom_body);
  if (turned.isZero(0.0)) end_turned();
  Mat6 seen = B * error_at(mean_epoch) * B.transpose();
  for (const HeldAlong& h : held) {
    const Mat6 other = B * error_at(h.mean_epoch) * B.transpose();
    const Mat3 more = (other - seen).bottomRightCorner<3, 3>();
    const double more_m2 = std::max(0.0, h.d_odom.dot(more * h.d_odom));
    seen.bottomRightCorner<3, 3>() += more_m2 * h.d_odom * h.d_odom.transpose();
  }
  const Mat6 before = B * carried_ * B.transpose();
  map_error_ = following.follows * seen * following.follows.transpose() +
               following.keeps * before * following.keeps.transpose();
  if (level) hold_level(T_odom_body, *level);
  bound_to_unknown();
  establish(T_odom_body.p);
  const Mat6 registered = following.follows * P_local * following.follows.transpose();
  const Mat6 added = P_local + (settings_.growth - 1.0) * registered;
  const Mat6 error = A * (map_error_ + added) * A.transpose();
  const bool makes_first = std::exchange(unmade_, false) && mean_epoch + 1.0 <= epoch_;
  if (makes_first) D_.back() = error;
  const bool travelled = (T_odom_body.p - begun_odom_m_.back()).norm() > settings_.epoch_m;
  if (travelled || has_grown(B * D_.back() * B.transpose(), map_error_ + P_local)) {
    const double passed = std::max(1.0, epoch_ - mean_epoch);
    rotation_ += T_odom_body.R * added.topLeftCorner<3, 3>() * T_odom_body.R.transpose() / passed;
    start_epoch(T_odom_body, error);
    if (!turned.isZero(0.0)) turned_.push_back({D_.size() - 1, A * turned * A.transpose()});
    unmade_ = true;
  }
  carried_ = A * map_error_ * A.transpose();
  const Vec6 known = level ? bent(T_odom_body, mean_epoch, *level) : Vec6(Vec6::Zero());
  return map_error_ + P_local + turned + known * known.transpose();
}

void Drift::start_epoch(const SE3& T_odom_body, const Mat6& error) {
  ++epoch_;
  D_.push_back(error);
  const auto n = static_cast<double>(middle_odom_m_.size());
  middle_odom_m_.emplace_back((n * middle_odom_m_.back() + T_odom_body.p) / (n + 1.0));
  begun_odom_m_.push_back(T_odom_body.p);
}

void Drift::end_turned() {
  for (const Turned& t : turned_) D_[t.generation] += t.P;
  turned_.clear();
}

void Drift::establish(const Vec3& p_odom_m) {
  constexpr double kAway_m = 1.25;  // longer than a cart
  constexpr double kMoved_m = 0.1;
  const Vec3& start = begun_odom_m_.front();
  // A generation lasts until the next one starts.
  while (established_ + 1 < begun_odom_m_.size() &&
         (p_odom_m - begun_odom_m_[established_ + 1]).norm() > kAway_m) {
    ++established_;
  }
  // The first map, and the one after gravity is initialised. Later generations at standstill start
  // only because the vehicle may have moved.
  constexpr std::size_t kFirst = 2;
  if (unmoved_) established_ = std::min(begun_odom_m_.size(), kFirst);
  unmoved_ = unmoved_ && (p_odom_m - start).norm() < kMoved_m;
}

namespace {

/// Bounds the covariance of rotations about N axes. A larger variance is reduced by a measurement
/// whose noise yields exactly the bound, so repeated calls do not reduce it further.
/// @param axes_body N unit vectors, row by row
template <int N>
void bound_rotation(const Eigen::Matrix<double, N, 3>& axes_body,
                    const Eigen::Matrix<double, N, N>& allowed, Mat6& P) {
  using Square = Eigen::Matrix<double, N, N>;
  const Square now = axes_body * P.topLeftCorner<3, 3>() * axes_body.transpose();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Square> ratios(now, allowed);
  if (ratios.info() != Eigen::Success) return;
  for (int k = 0; k < N; ++k) {
    const double ratio = ratios.eigenvalues()[k];
    if (!(ratio > 1.0)) continue;
    const Vec6 correlated = P.leftCols<3>() * axes_body.transpose() * ratios.eigenvectors().col(k);
    P -= correlated * correlated.transpose() * ((1.0 - 1.0 / ratio) / ratio);
  }
}

}  // namespace

/// Bounds the tilt of the map against the first pose by what gravity and the first pose allow.
void Drift::hold_level(const SE3& T_odom_body, const Level& level) {
  const Eigen::Matrix2d allowed =
      level.covariance + squared_rad(settings_.start_tilt_deg) * Eigen::Matrix2d::Identity();
  bound_rotation<2>(level.axes_odom.transpose() * T_odom_body.R, allowed, map_error_);
}

/// A rotation cannot be less known than not at all. Otherwise each generation turns the next one's
/// position by more, and the covariance grows without limit.
void Drift::bound_to_unknown() {
  constexpr double kUnknown_rad2 = std::numbers::pi * std::numbers::pi / 3.0;  // uniform
  if (map_error_.topLeftCorner<3, 3>().trace() < kUnknown_rad2) return;
  bound_rotation<3>(Mat3::Identity(), kUnknown_rad2 * Mat3::Identity(), map_error_);
}

Mat3 Drift::release(const SE3& T_odom_body, const Mat3& axes_odom) {
  const Mat3 released = axes_odom * map_error_.bottomRightCorner<3, 3>() * axes_odom;
  Mat6 rest = Mat6::Identity();
  rest.bottomRightCorner<3, 3>() -= axes_odom;
  map_error_ = (rest * map_error_ * rest).eval();
  const Mat6 A = left_from_boxplus(T_odom_body);
  carried_ = A * map_error_ * A.transpose();
  return released;
}

void Drift::add_everywhere(const SE3& T_odom_body, const Mat6& P) {
  const Mat6 A = left_from_boxplus(T_odom_body);
  const Mat6 added = A * P * A.transpose();
  for (Mat6& D : D_) D += added;
  carried_ += added;
}

Mat3 Drift::take_rotation() { return std::exchange(rotation_, Mat3::Zero()); }

void Drift::add(const SE3& T_odom_body, const Mat6& P) {
  const Mat6 A = left_from_boxplus(T_odom_body);
  start_epoch(T_odom_body, D_.back() + A * P * A.transpose());
  unmade_ = false;
  carried_ = D_.back();
  establish_all();
}

}  // namespace rali::odometry
