#include "rali/fleet/frames/drift_basis.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include <Eigen/Eigenvalues>

#include "rali/fleet/frames/yaw_pose.hpp"

namespace rali::fleet {

using geometry::Mat3;
using geometry::Vec3;

namespace {

/// Below this length a path has no direction, and its covariance growth is rounding error.
constexpr double kMinPath_m = 0.05;
constexpr double kMinSigma_m = 1e-3;
/// About twice the sigma of a range.
constexpr double kPieceGrowth_m = 0.25;
constexpr int kPiecesMax = 24;
constexpr double kMinOfMany_m = 0.01;  ///< 24 of them are less than half a range's sigma

/// Axes times sigma of the growth of a covariance; decreases count as zero.
std::vector<Vec3> growth_axes(const Mat3& before, const Mat3& after, double min_sigma_m) {
  const Mat3 grown = after - before;
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(Mat3(0.5 * (grown + grown.transpose())));
  std::vector<Vec3> out;
  for (int k = 0; k < 3; ++k) {
    const double sigma_m = std::sqrt(std::max(0.0, solver.eigenvalues()[k]));
    if (sigma_m >= min_sigma_m) out.emplace_back(sigma_m * solver.eigenvectors().col(k));
  }
  return out;
}

/// Fraction of the way from a to b, 0 to 1.
double fraction(double value, double a, double b) {
  return b > a ? std::clamp((value - a) / (b - a), 0.0, 1.0) : 0.0;
}

}  // namespace

DriftBasis::DriftBasis(std::vector<PathSample> path, const DriftSettings& settings)
    : path_(std::move(path)), settings_(settings) {
  std::stable_sort(path_.begin(), path_.end(),
                   [](const PathSample& a, const PathSample& b) { return a.t < b.t; });
  s_m_.assign(path_.size(), 0.0);
  for (std::size_t k = 1; k < path_.size(); ++k) {
    s_m_[k] = s_m_[k - 1] + (path_[k].p_m - path_[k - 1].p_m).norm();
  }
  if (path_.size() < 2 || s_m_.back() <= kMinPath_m) return;
  size_ = (settings.scale > 0.0 ? 1 : 0) + (settings.tilt_deg > 0.0 ? 2 : 0);
  add_turns();
  add_growth();
}

/// Position and reported covariance, interpolated between the neighbours.
PathSample DriftBasis::at_distance(double s_m) const {
  std::size_t k = 1;
  while (k + 1 < path_.size() && s_m_[k] < s_m) ++k;
  const double part = fraction(s_m, s_m_[k - 1], s_m_[k]);
  PathSample out = path_[k - 1];
  out.p_m += part * (path_[k].p_m - out.p_m);
  out.covariance_m2 += part * (path_[k].covariance_m2 - out.covariance_m2);
  return out;
}

double DriftBasis::distance_at(Time t) const {
  const auto after = std::lower_bound(path_.begin(), path_.end(), t,
                                      [](const PathSample& s, Time at) { return s.t < at; });
  if (after == path_.begin()) return 0.0;
  if (after == path_.end()) return s_m_.back();
  const auto k = static_cast<std::size_t>(after - path_.begin());
  const double part = fraction(seconds_between(path_[k - 1].t, t), 0.0,
                               seconds_between(path_[k - 1].t, path_[k].t));
  return s_m_[k - 1] + part * (s_m_[k] - s_m_[k - 1]);
}

/// Within a piece the error is linear, and a random walk is not: it leaves the line by up to half
/// of its growth there. Ranges would contradict the true frames by that, so where the growth is
/// large the pieces are short.
int DriftBasis::piece_count() const {
  double largest_m2 = 0.0;
  for (const PathSample& s : path_) largest_m2 = std::max(largest_m2, s.covariance_m2.trace());
  const double grown_m2 = largest_m2 - path_.front().covariance_m2.trace();
  const double count = grown_m2 / (kPieceGrowth_m * kPieceGrowth_m);
  if (!(count > settings_.segments)) return settings_.segments;
  return std::max(settings_.segments, static_cast<int>(std::min<double>(kPiecesMax, count)));
}

void DriftBasis::add_turns() {
  const double length_m = s_m_.back() / settings_.segments;
  turn_rad_ = settings_.yaw_deg_per_sqrt_m * kDegree * std::sqrt(length_m);
  if (!(turn_rad_ > 0.0)) return;
  for (int k = 0; k < settings_.segments; ++k) {
    const double at_m = length_m * (k + 0.5);
    turns_.push_back({at_m, at_distance(at_m).p_m});
  }
  size_ += settings_.segments;
}

void DriftBasis::add_growth() {
  const int count = piece_count();
  const double min_sigma_m = count > settings_.segments ? kMinOfMany_m : kMinSigma_m;
  piece_m_ = s_m_.back() / count;
  for (int k = 0; k < count; ++k) {
    const double start_m = piece_m_ * k;
    growth_.push_back(
        {start_m, growth_axes(at_distance(start_m).covariance_m2,
                              at_distance(start_m + piece_m_).covariance_m2, min_sigma_m)});
    size_ += static_cast<Eigen::Index>(growth_.back().axes.size());
  }
}

void DriftBasis::add_rigid(const Vec3& p_m, Eigen::Matrix4Xd& out, Eigen::Index& column) const {
  const Vec3 d = p_m - path_.front().p_m;
  if (settings_.scale > 0.0) out.col(column++).tail<3>() = settings_.scale * d;
  if (!(settings_.tilt_deg > 0.0)) return;
  const double tilt = settings_.tilt_deg * kDegree;
  out.col(column++).tail<3>() = tilt * Vec3(0.0, -d.z(), d.y());
  out.col(column++).tail<3>() = tilt * Vec3(d.z(), 0.0, -d.x());
}

Eigen::Matrix4Xd DriftBasis::at(Time t, const Vec3& p_m) const {
  Eigen::Matrix4Xd out = Eigen::Matrix4Xd::Zero(4, size_);
  if (size_ == 0) return out;
  const double s_m = distance_at(t);
  Eigen::Index column = 0;
  add_rigid(p_m, out, column);
  for (const Turn& turn : turns_) {
    if (s_m > turn.at_m) {
      out(0, column) = turn_rad_;
      out.col(column).tail<3>() = turn_rad_ * quarter_turn(p_m - turn.place_m);
    }
    ++column;
  }
  for (const Growth& growth : growth_) {
    const double part = fraction(s_m, growth.start_m, growth.start_m + piece_m_);
    for (const Vec3& axis_m : growth.axes) out.col(column++).tail<3>() = part * axis_m;
  }
  return out;
}

}  // namespace rali::fleet
