#include "rali/ranging/peer_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

namespace rali::ranging {
namespace {

using geometry::Vec3;

constexpr double kTrackGap_s = 0.5;
constexpr double kBiasSigma_m = 0.5;
/// A level track does not determine the sign of the peer's height.
constexpr double kHeightSigma_m = 3.0;
/// Odometry drifts by a per cent at walking speed, wherever it is not degenerate.
constexpr double kSpeedSigma_mps = 0.01;
/// Where it is: by an accelerometer's bias and tilt, per metre per second of the speed's sigma.
constexpr double kAccelPerSpeed_s = 0.05;
constexpr double kAccelSigmaMin_mps2 = 1e-5;  // else none

constexpr Eigen::Index kBias = 3, kSpeed = 4, kAccel = 7;

}  // namespace

std::optional<TrackPoint> point_at(Track track, Time t) {
  const auto after = std::lower_bound(track.begin(), track.end(), t,
                                      [](const TrackPoint& p, Time at) { return p.t < at; });
  if (after == track.begin() || after == track.end()) return std::nullopt;
  const TrackPoint &a = *std::prev(after), &b = *after;
  const double span_s = seconds_between(a.t, b.t);
  if (span_s > kTrackGap_s || a.piece != b.piece) return std::nullopt;
  const double s = seconds_between(a.t, t) / span_s;
  return TrackPoint{t, a.p_odom_m + s * (b.p_odom_m - a.p_odom_m), a.piece,
                    std::max(a.speed_sigma_mps, b.speed_sigma_mps)};
}

double extent_m(Track track) {
  if (track.empty()) return 0.0;
  Vec3 low = track.front().p_odom_m, high = low;
  for (const TrackPoint& point : track) {
    low = low.cwiseMin(point.p_odom_m);
    high = high.cwiseMax(point.p_odom_m);
  }
  return (high - low).norm();
}

PeerFit::PeerFit(Track track, std::span<const TimedRange> ranges, double offset_s) {
  if (ranges.empty()) return;
  const double middle_s = 0.5 * seconds_between(ranges.front().t, ranges.back().t);
  samples_.reserve(ranges.size());
  speed_sigma_mps_ = kSpeedSigma_mps;
  for (const TimedRange& range : ranges) {
    const auto point = point_at(track, range.t - Duration::from_s(offset_s));
    if (!point) continue;
    const double t_s = seconds_between(ranges.front().t, range.t) - middle_s;
    samples_.push_back({point->p_odom_m, range.range_m, t_s});
    speed_sigma_mps_ = std::max(speed_sigma_mps_, point->speed_sigma_mps);
  }
}

bool PeerFit::solve() {
  if (samples_.size() < kRangesMin) return false;
  start();
  const State linear = x_;
  descend();
  // Along a track that is nearly straight, the other side fits almost as well.
  try_from(mirrored(linear));
  return x_.allFinite();
}

void PeerFit::try_from(const State& start) {
  const State known = x_;
  const double known_cost = cost();
  x_ = start;
  descend();
  if (!(cost() < known_cost)) x_ = known;
}

/// Sum of the autocorrelation, up to where it has vanished.
double PeerFit::alike() const {
  std::vector<double> residuals;
  double power = 0.0;
  for (const Sample& s : samples_) {
    residuals.push_back(std::clamp(residual_m(s), -kScale_m, kScale_m));
    power += residuals.back() * residuals.back();
  }
  double sum = 1.0;
  for (std::size_t lag = 1; lag < residuals.size() / 4 && power > 0.0; ++lag) {
    double product = 0.0;
    for (std::size_t i = lag; i < residuals.size(); ++i) {
      product += residuals[i] * residuals[i - lag];
    }
    constexpr double kVanished = 0.05;
    if (product < kVanished * power) break;
    sum += 2.0 * product / power;
  }
  return sum;
}

void PeerFit::descend() {
  // From wide to narrow: the linear start is far off where the track's speed is.
  for (const double widening : {20.0, 1.0}) {
    double damping = 1e-3;
    double lowest = cost(widening * kScale_m);
    for (int i = 0; i < 30 && damping < 1e6; ++i) {
      const State before = x_;
      step(widening * kScale_m, damping);
      const double now = cost(widening * kScale_m);
      if (now < lowest) {
        const bool settled = lowest - now < 1e-6 * (1.0 + now);
        lowest = now;
        damping = std::max(0.3 * damping, 1e-9);
        if (settled) break;
      } else {
        x_ = before;
        damping *= 5.0;
      }
    }
  }
}

/// With the position on the other side of the track's main horizontal direction.
PeerFit::State PeerFit::mirrored(const State& state) const {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Sample& s : samples_) mean += s.p_m.head<2>();
  mean /= static_cast<double>(samples_.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const Sample& s : samples_) {
    const Eigen::Vector2d d = s.p_m.head<2>() - mean;
    spread += d * d.transpose();
  }
  // The main direction of a symmetric 2 x 2 matrix has twice the angle of this vector.
  const double angle = 0.5 * std::atan2(2.0 * spread(0, 1), spread(0, 0) - spread(1, 1));
  const Eigen::Vector2d side(-std::sin(angle), std::cos(angle));
  State other = state;
  other.head<2>() -= 2.0 * side.dot(state.head<2>() - mean) * side;
  return other;
}

Vec3 PeerFit::to_peer(const Sample& sample) const {
  const double t_s = sample.t_s;
  return x_.head<3>() - sample.p_m - t_s * x_.segment<3>(kSpeed) -
         0.5 * t_s * t_s * x_.segment<3>(kAccel);
}

double PeerFit::residual_m(const Sample& sample) const {
  return to_peer(sample).norm() + x_[kBias] - sample.range_m;
}

PeerFit::State PeerFit::prior_information() const {
  State information = State::Zero();
  information[2] = 1.0 / (kHeightSigma_m * kHeightSigma_m);
  information[kBias] = 1.0 / (kBiasSigma_m * kBiasSigma_m);
  const double accel_mps2 =
      kAccelSigmaMin_mps2 + kAccelPerSpeed_s * (speed_sigma_mps_ - kSpeedSigma_mps);
  information.segment<3>(kSpeed).setConstant(1.0 / (speed_sigma_mps_ * speed_sigma_mps_));
  information.segment<3>(kAccel).setConstant(1.0 / (accel_mps2 * accel_mps2));
  return information;
}

double PeerFit::cost(double scale_m) const {
  const double ratio = scale_m / kScale_m;
  double sum = 0.0;
  for (const Sample& s : samples_) {
    const double e = residual_m(s) / scale_m;
    sum += std::log1p(e * e);
  }
  // In units of kScale_m whatever the scale: the priors do not widen.
  return ratio * ratio * sum + x_.dot(prior_information().cwiseProduct(x_));
}

double PeerFit::rms_m() const {
  double sum = 0.0, weight = 0.0;
  for (const Sample& s : samples_) {
    const double e = residual_m(s), w = 1.0 / (1.0 + e * e / (kScale_m * kScale_m));
    sum += w * e * e;
    weight += w;
  }
  return weight > 0.0 ? std::sqrt(sum / weight) : 0.0;
}

/// r^2 - |p|^2 = -2 p a + (|a|^2), linear in the peer position a and its squared norm.
void PeerFit::start() {
  Eigen::Matrix4d H = Eigen::Matrix4d::Zero();
  Eigen::Vector4d b = Eigen::Vector4d::Zero();
  const double count = static_cast<double>(samples_.size());
  H.diagonal() = 1e-9 * count * Eigen::Vector4d::Ones();
  H(2, 2) += 1e-3 * count;
  for (const Sample& s : samples_) {
    const double scale = 1.0 / std::max(0.5, 2.0 * s.range_m);
    Eigen::Vector4d row;
    row << -2.0 * s.p_m, 1.0;
    row *= scale;
    H += row * row.transpose();
    b += row * scale * (s.range_m * s.range_m - s.p_m.squaredNorm());
  }
  x_.setZero();
  x_.head<3>() = H.ldlt().solve(b).head<3>();
}

void PeerFit::step(double scale_m, double damping) {
  // In units of kScale_m, as the cost.
  const State prior = prior_information() * (kScale_m * kScale_m);
  Eigen::Matrix<double, 10, 10> H = prior.asDiagonal();
  State b = -prior.cwiseProduct(x_);
  H.diagonal().array() += 1e-9;
  for (const Sample& s : samples_) {
    const Vec3 d = to_peer(s);
    const Vec3 u = d / std::max(d.norm(), 1e-3);
    State J;
    J << u, 1.0, -s.t_s * u, -0.5 * s.t_s * s.t_s * u;
    const double e = residual_m(s), w = 1.0 / (1.0 + e * e / (scale_m * scale_m));
    H += w * J * J.transpose();
    b -= w * e * J;
  }
  H.diagonal() *= 1.0 + damping;
  x_ += H.ldlt().solve(b);
}

}  // namespace rali::ranging
