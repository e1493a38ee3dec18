#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "rali/odometry/robust/internal/start_memory.hpp"

namespace rali::odometry::internal {

using geometry::Mat3;
using geometry::Vec3;
using sensor::LidarScan;

namespace {

constexpr double kHonestNis = 6.0;  // of six degrees of freedom

}  // namespace

/// Adds the fit of one replayed scan.
void RobustOdometry::add_fit(const LidarScan& scan, const UpdateResult& done,
                             const Vec3& ahead_odom, FirstSpeedFit& fit) const {
  constexpr double kSlipSigma_mps = 0.1;
  fit.nis += done.nis;
  if (settings_.constraints.non_holonomic) {
    const Vec3 rate = gyro_rate(scan.t_start, scan.t_end).value_or(state_.gyro_bias_radps);
    const double sigma = kSlipSigma_mps + kSlipPerRate_m * (rate - state_.gyro_bias_radps).norm();
    const Vec3 v_body = state_.T_odom_body.R.transpose() * state_.v;
    const Vec3 sideways = v_body - v_body.dot(forward_body_) * forward_body_;
    fit.sideways += sideways.squaredNorm() / (sigma * sigma);
  }
  if (done.matches == 0) return;
  const Vec3 up = -state_.g_odom_mps2.normalized();
  const double fraction = 1.0 / static_cast<double>(matcher_.size());
  for (const degeneracy::PlaneEvidence& plane : matcher_.evidence()) {
    const double upright = plane.n_odom.dot(up);
    const double facing = plane.n_odom.dot(ahead_odom);
    fit.on_walls += fraction * plane.points * (1.0 - upright * upright);
    fit.on_facing += fraction * plane.points * facing * facing;
  }
}

/// The LiDAR alone may converge to a wrong first speed: its rings on the floor move along with it,
/// and in a young map nothing outweighs them. So the first scans are replayed at speeds
/// forward and backward, as ground vehicles drive, with gravity from the mean force. A speed whose
/// sigma does not shrink in the replay is not confirmed.
/// @param guess its speed is tried as well; may be null
/// @return nothing: the scans confirm none
std::optional<RobustOdometry::FirstSpeed> RobustOdometry::find_first_speed(
    std::span<const LidarScan> scans, const FirstSpeed* guess, const StartMemory& before) {
  constexpr std::size_t kEnough = 40;
  constexpr double kStep_mps = 0.4;
  constexpr double kSigma_mps = 0.2;
  constexpr int kSteps = 8;
  constexpr double kSeen = 0.5;  // of the sigma assumed
  const auto few = scans.first(std::min(kEnough, scans.size()));
  const Vec3 force =
      imu::statistics(imu_.between(scans.front().t_end, scans.back().t_end)).accel_mean_mps2;
  const Mat3 R = track_.front().T_odom_body.R;
  const Vec3 g = -settings_.initialisation.gravity_mps2 * (R * force).normalized();
  const Vec3 ahead = R * forward_body_;
  std::vector<FirstSpeed> speeds;
  std::vector<TriedSpeed> tried;  // of each of them
  FindingList unsaid;
  const auto consider = [&](const FirstSpeed& first) {
    take(before);
    const FirstSpeedFit fit = replay(few, first, unsaid);
    const double value = value_of(fit);
    if (!(fit.speed_sigma_mps <= kSeen * kSigma_mps) || !std::isfinite(value)) return;
    speeds.push_back(first);
    tried.push_back({ahead.dot(first.v_odom_mps), fit.mean_mps, value});
  };
  if (guess != nullptr) consider({guess->v_odom_mps, guess->sigma_mps, g});
  for (int k = -kSteps; k <= kSteps; ++k) consider({k * kStep_mps * ahead, kSigma_mps, g});
  // Finer steps: from a wrong first speed, the first innovations make speed and gravity overshoot.
  for (const double finer_mps : {0.5 * kStep_mps, 0.25 * kStep_mps}) {
    const auto middle = std::max_element(
        tried.begin(), tried.end(),
        [](const TriedSpeed& a, const TriedSpeed& b) { return a.value < b.value; });
    if (middle == tried.end()) break;
    const Vec3 v_mps = speeds[static_cast<std::size_t>(middle - tried.begin())].v_odom_mps;
    for (const double side : {-1.0, 1.0}) {
      consider({v_mps + side * finer_mps * ahead, kSigma_mps, g});
    }
  }
  take(before);
  const std::optional<std::size_t> best = best_speed(tried, kSigma_mps);
  if (!best) return std::nullopt;
  return speeds[*best];
}

/// For a vehicle in motion when the recording began: its first scans were undistorted and
/// registered with unknown motion. Once speed, gravity and biases are known, they are replayed,
/// which removes the errors of the first second from the map. The first pose is kept. If no first
/// speed is confirmed and the LiDAR is degenerate, a map of few scans drags the pose along, so
/// there is no replay. If scans and prediction disagree in the replay, the sensor measured a force
/// that was no motion: nothing is changed.
void RobustOdometry::replay_start(const InitialGuess& guess, FindingList& findings) {
  if (start_scans_.size() < 2) return;
  const std::vector<LidarScan> scans = std::move(start_scans_);
  start_scans_.clear();
  const StartMemory before = start_memory();
  const FirstSpeed guessed{guess.v_first_mps, guess.v_first_sigma_mps};
  if (const auto first = find_first_speed(scans, &guessed, before)) {
    replay(scans, *first, findings);
    return;
  }
  if (degenerate_axis()) return;
  const FirstSpeedFit fit = replay(scans, guessed, findings);
  if (!(fit.nis < kHonestNis)) take(before);
}

/// A first speed may be confirmed before the LiDAR's track determines gravity.
/// @return false: nothing has changed
bool RobustOdometry::start_early(const InitialGuess& guess, FindingList& findings) {
  const double span_s = seconds_between(track_.front().t, state_.t);
  if (quiet_start_ || start_scans_.size() < 2 || span_s < next_search_s_) return false;
  next_search_s_ = 2.0 * std::max(span_s, settings_.initialisation.window_s);
  const StartMemory before = start_memory();
  start_inertial(guess);
  const auto first = find_first_speed(start_scans_, nullptr, start_memory());
  if (!first) {
    take(before);
    inertial_ = false;
    return false;
  }
  const std::vector<LidarScan> scans = std::move(start_scans_);
  start_scans_.clear();
  replay(scans, *first, findings);
  return true;
}

}  // namespace rali::odometry::internal
