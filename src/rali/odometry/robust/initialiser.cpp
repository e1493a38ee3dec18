#include "rali/odometry/robust/initialiser.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "rali/imu/kinematics.hpp"
#include "rali/odometry/robust/stillness.hpp"

namespace rali::odometry {

using geometry::Mat3;
using geometry::SE3;
using geometry::Vec3;
using sensor::ImuSample;

namespace {

constexpr double kRestSpeedSigma_mps = 0.01;
constexpr double kFirstSpeedSigma_mps = 0.5;

/// Scans of the track within the last window_s.
std::vector<TrackedPose> tail(const std::vector<TrackedPose>& track, double window_s) {
  const Time begin = track.back().t - Duration::from_s(window_s);
  std::vector<TrackedPose> out;
  for (const TrackedPose& p : track) {
    if (p.t >= begin) out.push_back(p);
  }
  return out;
}

/// Covariance of accelerometer bias and gravity's direction if gravity was computed from the
/// measured force: a bias then has the opposite error in gravity.
/// @param rest covariance of gravity from other causes [(m/s2)^2], in odom
Eigen::Matrix<double, 5, 5> bias_gravity_covariance(const Mat3& R_odom_body, const Vec3& g_mps2,
                                                    double bias_sigma_mps2, const Mat3& rest) {
  // A rotation by theta (perpendicular to g) moves g by theta x g; solved for theta.
  const Eigen::Matrix<double, 2, 3> J =
      gravity_basis(g_mps2).transpose() * geometry::skew(g_mps2) / g_mps2.squaredNorm();
  const Eigen::Matrix<double, 2, 3> J_bias = J * R_odom_body;
  const double var = bias_sigma_mps2 * bias_sigma_mps2;
  Eigen::Matrix<double, 5, 5> P;
  P << var * Mat3::Identity(), var * J_bias.transpose(), var * J_bias,
      var * J_bias * J_bias.transpose() + J * rest * J.transpose();
  return P;
}

/// The LiDAR shows that the vehicle moves within the window.
bool lidar_saw_motion(const std::vector<TrackedPose>& window, double limit_m) {
  const TrackedPose& first = window.front();
  return std::any_of(window.begin(), window.end(), [&](const TrackedPose& p) {
    return has_travelled(p.T_odom_body.p - first.T_odom_body.p,
                         p.covariance_m2 + first.covariance_m2, limit_m);
  });
}

std::optional<InitialGuess> solve_at_rest(const std::vector<TrackedPose>& track,
                                          const InertialBuffer& imu,
                                          const InitialisationSettings& settings,
                                          const ImuNoiseSettings& noise, bool same_view) {
  // The first poses of a new map settle by centimetres and are left out.
  const double window_s = settings.rest.window_s;
  if ((track.back().t - track.front().t).s() < window_s) return std::nullopt;
  const std::vector<TrackedPose> window = tail(track, 0.7 * window_s);
  const std::vector<ImuSample> raw = imu.between(window.front().t, window.back().t);
  const imu::ImuStatistics blocks = imu::statistics(block_means(raw));
  if (raw.size() < 20 || blocks.samples < 4 || !is_quiet(blocks, settings.rest) ||
      blocks.gyro_mean_radps.norm() > settings.rest.gyro_mean_max_radps ||
      lidar_saw_motion(window, settings.rest_travel_max_m)) {
    return std::nullopt;
  }
  // The end of the track decides on standstill; all quiet data are used for gravity.
  std::vector<ImuSample> quiet = imu.between(track.front().t, track.back().t);
  imu::ImuStatistics quiet_blocks = imu::statistics(block_means(quiet));
  if (!is_quiet(quiet_blocks, settings.rest)) {
    quiet = raw;
    quiet_blocks = blocks;
  }
  const imu::ImuStatistics all = imu::statistics(quiet);
  // Along a degenerate direction the LiDAR cannot prove standstill. An inertial sensor without
  // shaking can, or with that of an idling engine.
  Mat3 displacement = window.back().covariance_m2 + window.front().covariance_m2;
  if ((all.accel_sd_mps2.array() < settings.still_accel_sd_max_mps2).all() ||
      (same_view &&
       is_idling(imu.between(track.back().t - Duration::from_s(kIdling_s), track.back().t)))) {
    displacement.setZero();
  }
  const double unseen_m = std::sqrt(displacement.diagonal().maxCoeff());
  if (unseen_m > settings.rest_travel_max_m) return std::nullopt;
  InitialGuess guess;
  guess.at_rest = true;
  const double duration_s = (quiet.back().t - quiet.front().t).s();
  guess.gyro_bias_radps = all.gyro_mean_radps;
  guess.gyro_bias_sigma_radps =
      std::max(1e-4, noise.vibration_factor * noise.gyro_radps_rthz / std::sqrt(duration_s));
  const Vec3 f_odom = track.back().T_odom_body.R * all.accel_mean_mps2;
  guess.g_odom_mps2 = -settings.gravity_mps2 * f_odom.normalized();
  // At standstill the bias is observable along gravity; its horizontal part is indistinguishable
  // from a tilt, which the covariance of gravity expresses.
  guess.accel_bias_mps2 =
      (all.accel_mean_mps2.norm() - settings.gravity_mps2) * all.accel_mean_mps2.normalized();
  const double mean_var = quiet_blocks.accel_sd_mps2.cwiseAbs2().maxCoeff() / quiet_blocks.samples;
  guess.bias_gravity_covariance =
      bias_gravity_covariance(track.back().T_odom_body.R, guess.g_odom_mps2,
                              settings.accel_bias_sigma_mps2, mean_var * Mat3::Identity());
  guess.velocity_covariance = kRestSpeedSigma_mps * kRestSpeedSigma_mps * Mat3::Identity() +
                              displacement / (duration_s * duration_s);
  return guess;
}

/// Mean gyro bias for which integrated rates agree with the LiDAR's rotations.
Vec3 gyro_bias_from_rotations(const std::vector<TrackedPose>& track, const InertialBuffer& imu) {
  Vec3 bias = Vec3::Zero();
  for (int round = 0; round < 3; ++round) {
    Vec3 sum = Vec3::Zero();
    double time_s = 0.0;
    for (std::size_t k = 1; k < track.size(); ++k) {
      Mat3 R = Mat3::Identity();
      Time t = track[k - 1].t;
      for (const ImuSample& s : imu.between(t + Duration{1}, track[k].t)) {
        const Vec3 w = 0.5 * (imu.at(t).gyro_radps + s.gyro_radps) - bias;
        R = R * geometry::so3_exp(w * (s.t - t).s());
        t = s.t;
      }
      const Vec3 w = imu.at(track[k].t).gyro_radps - bias;
      R = R * geometry::so3_exp(w * (track[k].t - t).s());
      const Mat3 R_lidar = track[k - 1].T_odom_body.R.transpose() * track[k].T_odom_body.R;
      sum += geometry::so3_log(R_lidar.transpose() * R);
      time_s += (track[k].t - track[k - 1].t).s();
    }
    if (time_s <= 0.0) break;
    bias += sum / time_s;
  }
  return bias;
}

/// Velocity and position from the specific force alone since the first pose, with the attitude of
/// the LiDAR at each scan and of the gyro between scans.
struct ForceIntegral {
  std::vector<Vec3> dv, dp;  ///< at each pose of the track
};

ForceIntegral integrate_force(const std::vector<TrackedPose>& track, const InertialBuffer& imu,
                              const Vec3& gyro_bias) {
  ForceIntegral out;
  imu::KinematicState s{track.front().T_odom_body, Vec3::Zero()};
  s.T_odom_body.p.setZero();
  out.dv.push_back(Vec3::Zero());
  out.dp.push_back(Vec3::Zero());
  for (std::size_t k = 1; k < track.size(); ++k) {
    s.T_odom_body.R = track[k - 1].T_odom_body.R;
    Time t = track[k - 1].t;
    const auto step = [&](Time to) {
      const ImuSample a = imu.at(t);
      const ImuSample b = imu.at(to);
      imu::integrate(s, 0.5 * (a.gyro_radps + b.gyro_radps) - gyro_bias,
                     0.5 * (a.accel_mps2 + b.accel_mps2), Vec3::Zero(), (to - t).s());
      t = to;
    };
    for (const ImuSample& sample : imu.between(t + Duration{1}, track[k].t)) step(sample.t);
    if (t < track[k].t) step(track[k].t);
    out.dv.push_back(s.v_odom_mps);
    out.dp.push_back(s.T_odom_body.p);
  }
  return out;
}

/// p_k = p_0 + v_0 t + g t^2/2 + dp_k, solved for x = (p_0, v_0, g).
struct MotionFit {
  Eigen::Matrix<double, 9, 1> x;
  Eigen::Matrix<double, 9, 9> covariance;
};

/// @param g_guess gravity from the mean force: the prior where the LiDAR is degenerate
/// @param speed_sigma_mps of the first speed: likewise
MotionFit fit_motion(const std::vector<TrackedPose>& track, const ForceIntegral& force,
                     const Vec3& g_guess, double speed_sigma_mps) {
  constexpr double kPoseFloor_m = 0.005;  // error of the poses in a young map
  Eigen::Matrix<double, 9, 9> N = Eigen::Matrix<double, 9, 9>::Zero();
  Eigen::Matrix<double, 9, 1> rhs = Eigen::Matrix<double, 9, 1>::Zero();
  const double prior = 1.0 / (kMeanForceSigma_mps2 * kMeanForceSigma_mps2);
  N.block<3, 3>(3, 3) = 1.0 / (speed_sigma_mps * speed_sigma_mps) * Mat3::Identity();
  N.bottomRightCorner<3, 3>() = prior * Mat3::Identity();
  rhs.tail<3>() = prior * g_guess;
  const auto row_at = [&](std::size_t k) {
    const double t = (track[k].t - track.front().t).s();
    return Vec3(1.0, t, 0.5 * t * t);
  };
  const auto weight_of = [&](std::size_t k) -> Mat3 {
    return (track[k].covariance_m2 + kPoseFloor_m * kPoseFloor_m * Mat3::Identity()).inverse();
  };
  for (std::size_t k = 0; k < track.size(); ++k) {
    const Vec3 row = row_at(k);
    const Mat3 W = weight_of(k);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) N.block<3, 3>(3 * i, 3 * j) += row[i] * row[j] * W;
      rhs.segment<3>(3 * i) += row[i] * (W * (track[k].T_odom_body.p - force.dp[k]));
    }
  }
  MotionFit fit;
  fit.covariance = N.inverse();
  fit.x = fit.covariance * rhs;
  double chi2 = 0.0;
  for (std::size_t k = 0; k < track.size(); ++k) {
    const Vec3 row = row_at(k);
    const Vec3 e = track[k].T_odom_body.p - force.dp[k] - row[0] * fit.x.head<3>() -
                   row[1] * fit.x.segment<3>(3) - row[2] * fit.x.tail<3>();
    chi2 += e.dot(weight_of(k) * e);
  }
  const double dof = std::max(1.0, 3.0 * static_cast<double>(track.size()) - 9.0);
  fit.covariance *= std::max(1.0, chi2 / dof);
  return fit;
}

std::optional<InitialGuess> solve_in_motion(const std::vector<TrackedPose>& track,
                                            const InertialBuffer& imu,
                                            const InitialisationSettings& settings,
                                            double speed_usual_mps) {
  constexpr double kGravitySigmaMax_mps2 = 0.3;
  constexpr double kGravityError_mps2 = 1.0;      // more is another unit, not a bias
  constexpr double kGravitySigmaLate_rad = 0.09;  // 5 deg
  if (static_cast<int>(track.size()) < settings.scans_min) return std::nullopt;
  const double duration_s = (track.back().t - track.front().t).s();
  if (duration_s < settings.window_s) return std::nullopt;
  const Vec3 bias = gyro_bias_from_rotations(track, imu);
  const ForceIntegral force = integrate_force(track, imu, bias);
  const Vec3 g_guess = -force.dv.back() / duration_s;
  const MotionFit fit = fit_motion(track, force, g_guess, speed_usual_mps);
  const Vec3 g = fit.x.tail<3>();
  const Mat3 g_cov = fit.covariance.bottomRightCorner<3, 3>();
  const double sigma_g = std::sqrt(g_cov.diagonal().maxCoeff());
  const bool late = duration_s > settings.give_up_s;
  const auto is_gravity = [&settings](const Vec3& a_mps2) {
    return std::abs(a_mps2.norm() - settings.gravity_mps2) < kGravityError_mps2;
  };
  const bool plausible = is_gravity(g);
  if (!late && !is_gravity(g_guess)) return std::nullopt;
  InitialGuess guess;
  guess.gravity_known = late || (sigma_g <= kGravitySigmaMax_mps2 && plausible);
  guess.gyro_bias_radps = bias;
  guess.gyro_bias_sigma_radps = std::max(0.002, 0.01 / duration_s);
  guess.g_odom_mps2 = settings.gravity_mps2 * (plausible ? g : g_guess).normalized();
  const double late_sigma = kGravitySigmaLate_rad * settings.gravity_mps2;
  guess.bias_gravity_covariance = bias_gravity_covariance(
      track.back().T_odom_body.R, guess.g_odom_mps2, settings.accel_bias_sigma_mps2,
      plausible ? Mat3(4.0 * g_cov) : Mat3(late_sigma * late_sigma * Mat3::Identity()));
  guess.v_first_mps = fit.x.segment<3>(3);
  guess.v_first_sigma_mps =
      2.0 * std::sqrt(fit.covariance.block<3, 3>(3, 3).diagonal().maxCoeff()) + 0.1;
  guess.v_odom_mps = guess.v_first_mps + guess.g_odom_mps2 * duration_s + force.dv.back();
  Eigen::Matrix<double, 3, 9> J = Eigen::Matrix<double, 3, 9>::Zero();
  J.middleCols<3>(3).setIdentity();
  J.rightCols<3>() = duration_s * Mat3::Identity();
  guess.velocity_covariance = J * (4.0 * fit.covariance) * J.transpose() + 0.01 * Mat3::Identity();
  return guess;
}

}  // namespace

std::optional<InitialGuess> solve_initial(const std::vector<TrackedPose>& track,
                                          const InertialBuffer& imu,
                                          const InitialisationSettings& settings,
                                          const ImuNoiseSettings& noise, bool same_view,
                                          double speed_usual_mps) {
  if (track.size() < 2 || imu.empty()) return std::nullopt;
  if (auto guess = solve_at_rest(track, imu, settings, noise, same_view)) {
    // Now at standstill, it may have been moving when the track began; the first scans give that
    // speed.
    const TrackedPose& later = track[std::min<std::size_t>(2, track.size() - 1)];
    guess->v_first_mps =
        (later.T_odom_body.p - track.front().T_odom_body.p) / (later.t - track.front().t).s();
    guess->v_first_sigma_mps = kFirstSpeedSigma_mps;
    return guess;
  }
  return solve_in_motion(track, imu, settings, speed_usual_mps);
}

}  // namespace rali::odometry
