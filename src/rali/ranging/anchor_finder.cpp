#include "rali/ranging/anchor_finder.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace rali::ranging {

using geometry::Mat3;
using geometry::Vec3;

namespace {

/// Two unit vectors normal to `up`.
Eigen::Matrix<double, 3, 2> level_axes(const Vec3& up) {
  const Vec3 helper = std::abs(up.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY();
  Eigen::Matrix<double, 3, 2> axes;
  axes.col(0) = (helper - helper.dot(up) * up).normalized();
  axes.col(1) = up.cross(Vec3(axes.col(0)));
  return axes;
}

Mat3 clipped_inverse(const Mat3& S, double minimum) {
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(S);
  const Vec3 values = solver.eigenvalues().cwiseMax(minimum).cwiseInverse();
  return solver.eigenvectors() * values.asDiagonal() * solver.eigenvectors().transpose();
}

/// One invalid number would spoil the sums of all samples after it.
bool usable(const FinderSample& sample) {
  return std::isfinite(sample.range_m) && sample.sigma_m > 0.0 &&
         sample.p_odom_antenna_m.allFinite() && sample.covariance_m2.allFinite();
}

}  // namespace

FoundAnchor place_along_passage(const FinderSettings& settings, const FinderSample& sample,
                                double height_m, double bias_m, const Vec3& up_odom, bool ahead,
                                const LateralOffset& lateral) {
  const Vec3& axis = *sample.passage_odom;
  const Vec3 towards = ahead ? axis : Vec3(-axis);
  const Vec3 across = up_odom.cross(axis).normalized();
  const double distance_m = std::max(1e-3, sample.range_m - bias_m);
  const double up_m = settings.height_sigma_m + settings.rise_per_m * sample.range_m;
  // A lateral offset shortens the distance along the passage by its square over twice the distance:
  // mean and sigma of that.
  const double a2 = lateral.mean_m * lateral.mean_m;
  const double s2 = lateral.sigma_m * lateral.sigma_m;
  const double nearer_m = 0.5 * (a2 + s2) / distance_m;
  const double nearer_sigma_m = 0.5 * std::sqrt(2.0 * s2 * s2 + 4.0 * a2 * s2) / distance_m;
  const double along_m = std::hypot(sample.sigma_m, nearer_sigma_m);
  FoundAnchor found;
  found.p_odom_m = sample.p_odom_antenna_m + height_m * up_odom +
                   (distance_m - nearer_m) * towards + lateral.mean_m * across;
  found.covariance_m2 = along_m * along_m * axis * axis.transpose() +
                        s2 * across * across.transpose() +
                        up_m * up_m * up_odom * up_odom.transpose();
  return found;
}

/// Neighbouring ranges share their error: one per distance travelled, at standstill one per time.
bool AnchorFinder::keep(const FinderSample& sample) {
  if (samples_.empty()) return true;
  const FinderSample& last = samples_.back();
  const double moved_m = (sample.p_odom_antenna_m - last.p_odom_antenna_m).norm();
  const double waited_s = seconds_between(last.t, sample.t);
  return moved_m >= settings_.spacing_m || waited_s >= settings_.spacing_s;
}

std::optional<FoundAnchor> AnchorFinder::add(const FinderSample& sample, double height_m,
                                             const Vec3& up_odom) {
  up_ = up_odom;
  height_m_ = height_m;
  if (!usable(sample) || !keep(sample)) return std::nullopt;
  if (samples_.empty()) {
    travelled_m_ = asked_at_m_ = 0.0;
  } else {
    travelled_m_ += (sample.p_odom_antenna_m - samples_.back().p_odom_antenna_m).norm();
  }
  samples_.push_back(sample);
  if (samples_.size() > static_cast<std::size_t>(settings_.samples_max)) {
    samples_.erase(samples_.begin());
  }
  if (far_in_passage(sample)) return along_passage();
  const bool enough = samples_.size() >= static_cast<std::size_t>(settings_.samples_min) &&
                      travelled_m_ >= settings_.travel_min_m &&
                      travelled_m_ >= asked_at_m_ + settings_.travel_again_m;
  if (!enough) return std::nullopt;
  asked_at_m_ = travelled_m_;
  return decide(solutions());
}

/// The range is so long that bends of the passage hide the lateral position.
bool AnchorFinder::far_in_passage(const FinderSample& sample) const {
  return sample.passage_odom && sample.range_m * settings_.passage_per_m > 1.0;
}

/// Ahead or behind, by ranges that get shorter or longer along the own path. The rest is left open.
std::optional<FoundAnchor> AnchorFinder::along_passage() const {
  const FinderSample& first = samples_.front();
  const FinderSample& last = samples_.back();
  const Vec3& axis = *last.passage_odom;
  const double moved_m = axis.dot(last.p_odom_antenna_m - first.p_odom_antenna_m);
  const double closer_m = first.range_m - last.range_m;
  const bool reported = std::abs(moved_m) > settings_.travel_min_m &&
                        std::abs(closer_m) > 0.5 * settings_.travel_min_m;
  if (!reported) return std::nullopt;
  const bool ahead = moved_m * closer_m > 0.0;
  const Vec3 towards = ahead ? axis : Vec3(-axis);
  FoundAnchor found =
      place_along_passage(settings_, last, height_m_, bias_m_, up_, ahead,
                          lateral_offset_in_passage(settings_, last.by_walls, last.range_m));
  found.per_bias = -towards;
  found.bias_m = bias_m_;
  found.bias_sigma_m = bias_sigma_m_;
  found.covariance_m2 += bias_sigma_m_ * bias_sigma_m_ * towards * towards.transpose();
  return found;
}

LateralOffset AnchorFinder::lateral_now() const {
  const FinderSample& last = samples_.back();
  return lateral_offset_in_passage(settings_, last.by_walls, last.range_m);
}

AnchorFinder::Mat7 AnchorFinder::prior_information() const {
  Mat7 I = Mat7::Zero();
  const double height_weight = 1.0 / (settings_.height_sigma_m * settings_.height_sigma_m);
  I.topLeftCorner<3, 3>() = height_weight * up_ * up_.transpose();
  if (samples_.back().passage_odom) {
    const Vec3 across = up_.cross(*samples_.back().passage_odom).normalized();
    const double sigma_m = lateral_now().sigma_m;
    I.topLeftCorner<3, 3>() += across * across.transpose() / (sigma_m * sigma_m);
  }
  I(3, 3) = 1.0 / (bias_sigma_m_ * bias_sigma_m_);
  // The growth of the position's covariance since the first sample, as an error of speed.
  const double span_s = std::max(0.1, seconds_between(samples_.front().t, samples_.back().t));
  const Mat3 gained = samples_.back().covariance_m2 - samples_.front().covariance_m2;
  const double minimum = settings_.speed_sigma_min_mps * settings_.speed_sigma_min_mps;
  I.bottomRightCorner<3, 3>() = clipped_inverse(gained / (span_s * span_s), minimum);
  return I;
}

/// Normal equations at x; the own position errs by speed times time since the first sample.
/// @return sum of squares in sigma, robustly weighted
double AnchorFinder::linearise(const Vec7& x, Mat7& H, Vec7& g) const {
  const Mat7 I = prior_information();
  Vec7 from_prior = x;
  const Vec3& p0 = samples_.front().p_odom_antenna_m;
  from_prior.head<3>() -= p0 + height_m_ * up_;
  if (const auto& passage = samples_.back().passage_odom) {
    from_prior.head<3>() -= lateral_now().mean_m * up_.cross(*passage).normalized();
  }
  from_prior[3] -= bias_m_;
  H = I;
  g = I * from_prior;
  double cost = from_prior.dot(g);
  for (const FinderSample& s : samples_) {
    const double dt_s = seconds_between(samples_.front().t, s.t);
    const Vec3 h = s.p_odom_antenna_m + dt_s * x.tail<3>() - x.head<3>();
    const double rho = std::max(1e-3, h.norm());
    const double r = (rho + x[3] - s.range_m) / s.sigma_m;
    const double weight = std::abs(r) > settings_.huber ? settings_.huber / std::abs(r) : 1.0;
    Vec7 J;
    J.head<3>() = -h / rho;
    J[3] = 1.0;
    J.tail<3>() = dt_s * h / rho;
    J /= s.sigma_m;
    H += weight * J * J.transpose();
    g += weight * r * J;
    cost += weight * r * r;
  }
  return cost;
}

AnchorFinder::Solution AnchorFinder::refine(Vec7 x) const {
  Solution best;
  Mat7 H;
  Vec7 g;
  double cost = linearise(x, H, g);
  double lambda = 1e-3;
  for (int k = 0; k < settings_.iterations; ++k) {
    Mat7 damped = H;
    damped.diagonal() *= 1.0 + lambda;
    const Vec7 step = -damped.ldlt().solve(g);
    Mat7 H_new;
    Vec7 g_new;
    const double cost_new = linearise(x + step, H_new, g_new);
    if (cost_new < cost) {
      x += step;
      const bool done = cost - cost_new < 1e-6 * cost;
      cost = cost_new;
      H = H_new;
      g = g_new;
      lambda = std::max(1e-9, 0.1 * lambda);
      if (done) break;
    } else {
      lambda *= 10.0;
      if (lambda > 1e8) break;
    }
  }
  best.x = x;
  best.information = H;
  best.cost = cost;
  return best;
}

/// Distinct minima, best first.
std::vector<AnchorFinder::Solution> AnchorFinder::solutions() const {
  const FinderSample& first = samples_.front();
  const Eigen::Matrix<double, 3, 2> level = level_axes(up_);
  const double flat_m =
      std::sqrt(std::max(0.01, first.range_m * first.range_m - height_m_ * height_m_));
  std::vector<Solution> out;
  for (int k = 0; k < settings_.directions; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / settings_.directions;
    Vec7 x = Vec7::Zero();
    x.head<3>() = first.p_odom_antenna_m + height_m_ * up_ +
                  flat_m * (std::cos(angle) * level.col(0) + std::sin(angle) * level.col(1));
    x[3] = bias_m_;
    const Solution s = refine(x);
    const auto same = std::find_if(out.begin(), out.end(), [&](const Solution& o) {
      return (o.x.head<3>() - s.x.head<3>()).norm() < settings_.merge_m;
    });
    if (same == out.end()) {
      out.push_back(s);
    } else if (s.cost < same->cost) {
      *same = s;
    }
  }
  std::sort(out.begin(), out.end(),
            [](const Solution& a, const Solution& b) { return a.cost < b.cost; });
  return out;
}

/// True if the two positions are mirror images across the vertical plane through the own path.
bool AnchorFinder::is_mirror(const Solution& a, const Solution& b) const {
  Vec3 mean = Vec3::Zero();
  for (const FinderSample& s : samples_) mean += s.p_odom_antenna_m;
  mean /= static_cast<double>(samples_.size());
  const Eigen::Matrix<double, 3, 2> level = level_axes(up_);
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const FinderSample& s : samples_) {
    const Eigen::Vector2d d = level.transpose() * (s.p_odom_antenna_m - mean);
    spread += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(spread);
  const Eigen::Vector2d across = solver.eigenvectors().col(0);
  const Eigen::Vector2d along = solver.eigenvectors().col(1);
  const Eigen::Vector2d qa = level.transpose() * (a.x.head<3>() - mean);
  const Eigen::Vector2d qb = level.transpose() * (b.x.head<3>() - mean);
  const double tolerance_m = 2.0 * settings_.merge_m;
  return std::abs(along.dot(qa - qb)) < tolerance_m && std::abs(across.dot(qa + qb)) < tolerance_m;
}

std::optional<FoundAnchor> AnchorFinder::decide(const std::vector<Solution>& all) const {
  const Solution& best = all.front();
  const auto freedom = static_cast<double>(samples_.size());
  if (best.cost > settings_.chi2_max * freedom) return std::nullopt;
  FoundAnchor found;
  found.p_odom_m = best.x.head<3>();
  const Mat7 P = best.information.inverse();
  found.covariance_m2 = P.topLeftCorner<3, 3>();
  found.per_bias = P.block<3, 1>(0, 3) / P(3, 3);
  found.bias_m = best.x[3];
  found.bias_sigma_m = std::sqrt(P(3, 3));
  for (std::size_t k = 1; k < all.size(); ++k) {
    if (all[k].cost > best.cost + settings_.rival_chi2) break;
    if (!is_mirror(best, all[k])) return std::nullopt;
    const Vec3 apart = all[k].x.head<3>() - best.x.head<3>();
    found.covariance_m2 += apart * apart.transpose();
    found.mirrored = true;
  }
  // Along the line of sight the position must be certain: later ranges constrain the pose by it.
  const Vec3 sight = (samples_.back().p_odom_antenna_m - found.p_odom_m).normalized();
  const double sigma2 = sight.dot(found.covariance_m2 * sight);
  const bool certain = sigma2 < settings_.sigma_max_m * settings_.sigma_max_m;
  return certain ? std::optional(found) : std::nullopt;
}

}  // namespace rali::ranging
