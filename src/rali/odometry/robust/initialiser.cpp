#include "rali/odometry/robust/initialiser.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "rali/imu/kinematics.hpp"
#include "rali/odometry/robust/block_means.hpp"

namespace rali::odometry {

using geometry::Mat3;
using geometry::SE3;
using geometry::Vec3;
using sensor::ImuSample;

namespace {

/// Scans of the track within the last window_s.
std::vector<TrackedPose> tail(const std::vector<TrackedPose>& track, double window_s) {
  const Time begin = track.back().t - Duration::from_s(window_s);
  std::vector<TrackedPose> out;
  for (const TrackedPose& p : track) {
    if (p.t >= begin) out.push_back(p);
  }
  return out;
}

std::optional<InitialGuess> solve_at_rest(const std::vector<TrackedPose>& track,
                                          const InertialBuffer& imu,
                                          const InitialisationSettings& settings,
                                          const ImuNoiseSettings& noise) {
  // The first scans of a new map settle by centimetres: they do not count.
  const double window_s = settings.rest.window_s;
  if ((track.back().t - track.front().t).s() < window_s) return std::nullopt;
  const std::vector<TrackedPose> window = tail(track, 0.7 * window_s);
  const std::vector<ImuSample> raw = imu.between(window.front().t, window.back().t);
  if (raw.size() < 20) return std::nullopt;
  const imu::ImuStatistics blocks = imu::statistics(block_means(raw));
  if (blocks.samples < 4) return std::nullopt;
  if (blocks.gyro_sd_radps.maxCoeff() > settings.rest.gyro_sd_max_radps ||
      blocks.accel_sd_mps2.maxCoeff() > settings.rest.accel_sd_max_mps2 ||
      blocks.gyro_mean_radps.norm() > settings.rest.gyro_mean_max_radps) {
    return std::nullopt;
  }
  double travel_m = 0.0;
  double sigma_m = 0.0;
  for (const TrackedPose& p : window) {
    travel_m = std::max(travel_m, (p.T_odom_body.p - window.front().T_odom_body.p).norm());
    sigma_m = std::max(sigma_m, p.sigma_m);
  }
  if (travel_m > settings.rest_travel_max_m) return std::nullopt;
  const imu::ImuStatistics all = imu::statistics(raw);
  InitialGuess guess;
  guess.at_rest = true;
  const double duration_s = (window.back().t - window.front().t).s();
  guess.gyro_bias_radps = all.gyro_mean_radps;
  guess.gyro_bias_sigma_radps =
      std::max(1e-4, noise.vibration_factor * noise.gyro_radps_rthz / std::sqrt(duration_s));
  const Vec3 f_odom = track.back().T_odom_body.R * all.accel_mean_mps2;
  guess.g_odom_mps2 = -settings.gravity_mps2 * f_odom.normalized();
  // The part of the bias along gravity shows at rest; the horizontal part is indistinguishable
  // from a tilt, which is what gravity_sigma says.
  guess.accel_bias_mps2 = (all.accel_mean_mps2.norm() - settings.gravity_mps2) *
                          all.accel_mean_mps2.normalized();
  guess.accel_bias_sigma_mps2 = settings.accel_bias_bound_mps2 / 5.0;
  guess.gravity_sigma_rad = guess.accel_bias_sigma_mps2 / settings.gravity_mps2;
  // Along a blind direction the LiDAR cannot prove that nothing moves.
  guess.velocity_sigma_mps = sigma_m > 0.5 ? 2.0 : 0.02;
  return guess;
}

/// Mean gyro bias that makes integrated rates agree with the LiDAR's rotations.
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

/// Velocity and position that the specific force alone gives from the first pose on, with the
/// attitude of the LiDAR at each scan and of the gyro between scans.
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

std::optional<InitialGuess> solve_in_motion(const std::vector<TrackedPose>& track,
                                            const InertialBuffer& imu,
                                            const InitialisationSettings& settings) {
  if (static_cast<int>(track.size()) < settings.scans_min) return std::nullopt;
  const double duration_s = (track.back().t - track.front().t).s();
  if (duration_s < settings.window_s) return std::nullopt;
  const Vec3 bias = gyro_bias_from_rotations(track, imu);
  const ForceIntegral force = integrate_force(track, imu, bias);
  // p_k = p_0 + v_0 t + g t^2/2 + dp_k, unknown p_0, v_0, g: three columns, the same matrix for
  // each axis.
  Mat3 N = Mat3::Zero();
  Mat3 rhs = Mat3::Zero();  // rows: unknowns, columns: axes
  for (std::size_t k = 0; k < track.size(); ++k) {
    const double t = (track[k].t - track.front().t).s();
    const Vec3 row(1.0, t, 0.5 * t * t);
    N += row * row.transpose();
    rhs += row * (track[k].T_odom_body.p - force.dp[k]).transpose();
  }
  const Mat3 N_inverse = N.inverse();
  const Mat3 x = N_inverse * rhs;
  double residual2 = 0.0;
  for (std::size_t k = 0; k < track.size(); ++k) {
    const double t = (track[k].t - track.front().t).s();
    const Vec3 predicted = x.transpose() * Vec3(1.0, t, 0.5 * t * t);
    residual2 += (track[k].T_odom_body.p - force.dp[k] - predicted).squaredNorm();
  }
  const double dof = std::max(1.0, 3.0 * static_cast<double>(track.size()) - 9.0);
  const double sigma_p = std::max(0.005, std::sqrt(residual2 / dof));
  const Vec3 g = x.row(2).transpose();
  const double sigma_g = sigma_p * std::sqrt(N_inverse(2, 2));
  const bool late = duration_s > settings.give_up_s;
  const bool plausible = std::abs(g.norm() - settings.gravity_mps2) < 1.0;
  if (!late && (sigma_g > 0.3 || !plausible)) return std::nullopt;
  InitialGuess guess;
  guess.gyro_bias_radps = bias;
  guess.gyro_bias_sigma_radps = std::max(0.002, 0.01 / duration_s);
  guess.accel_bias_sigma_mps2 = settings.accel_bias_bound_mps2 / 5.0;
  if (plausible) {
    guess.g_odom_mps2 = settings.gravity_mps2 * g.normalized();
    guess.gravity_sigma_rad =
        std::hypot(2.0 * sigma_g, guess.accel_bias_sigma_mps2) / settings.gravity_mps2;
  } else {
    const imu::ImuStatistics all = imu::statistics(imu.between(track.front().t, track.back().t));
    guess.g_odom_mps2 = -settings.gravity_mps2 *
                        (track.back().T_odom_body.R * all.accel_mean_mps2).normalized();
    guess.gravity_sigma_rad = 0.09;  // 5 deg
  }
  const double t_last = duration_s;
  guess.v_odom_mps =
      Vec3(x.row(1).transpose()) + guess.g_odom_mps2 * t_last + force.dv.back();
  guess.velocity_sigma_mps =
      std::clamp(sigma_p * std::sqrt(N_inverse(1, 1)) + 2.0 * sigma_g * t_last, 0.1, 2.0);
  double sigma_m = 0.0;
  for (const TrackedPose& p : track) sigma_m = std::max(sigma_m, p.sigma_m);
  if (sigma_m > 0.5) guess.velocity_sigma_mps = 2.0;
  return guess;
}

}  // namespace

std::optional<InitialGuess> solve_initial(const std::vector<TrackedPose>& track,
                                          const InertialBuffer& imu,
                                          const InitialisationSettings& settings,
                                          const ImuNoiseSettings& noise) {
  if (track.size() < 2 || imu.empty()) return std::nullopt;
  if (auto guess = solve_at_rest(track, imu, settings, noise)) return guess;
  return solve_in_motion(track, imu, settings);
}

}  // namespace rali::odometry
