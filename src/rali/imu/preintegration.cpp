#include "rali/imu/preintegration.hpp"

#include <algorithm>
#include <cmath>

namespace rali::imu {

using geometry::Mat3;
using geometry::skew;
using geometry::so3_exp;
using geometry::so3_log;
using geometry::so3_right_jacobian;
using geometry::so3_right_jacobian_inverse;
using geometry::Vec3;

Preintegration::Preintegration(const InertialBias& bias, const InertialNoise& noise)
    : bias_(bias), noise_(noise) {}

bool Preintegration::add(const Vec3& gyro_radps, const Vec3& accel_mps2, double dt_s) {
  if (!gyro_radps.allFinite() || !accel_mps2.allFinite()) return false;
  if (!(dt_s > 0.0 && dt_s <= kStepMaxS) || samples_ >= kSamplesMax) return false;
  integrate({gyro_radps, accel_mps2, dt_s});
  ++samples_;
  return true;
}

double Preintegration::add_stream(std::span<const sensor::ImuSample> samples, Time begin,
                                  Time end) {
  double covered_s = 0.0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const Time from = k == 0 ? begin : std::max(begin, samples[k].t);
    const Time to = k + 1 < samples.size() ? std::min(end, samples[k + 1].t) : end;
    if (to <= from) continue;
    const double dt_s = seconds_between(from, to);
    if (add(samples[k].gyro_radps, samples[k].accel_mps2, dt_s)) covered_s += dt_s;
  }
  return covered_s;
}

void Preintegration::reset(const InertialBias& bias) {
  bias_ = bias;
  samples_ = 0;
  clear_sums();
}

void Preintegration::clear_sums() {
  duration_s_ = 0.0;
  dR_.setIdentity();
  dv_.setZero();
  dp_.setZero();
  for (Mat3* J : {&dRg_, &dvg_, &dva_, &dpg_, &dpa_}) J->setZero();
  covariance_.setZero();
}

void Preintegration::integrate(const Step& step) {
  const Vec3 w = step.gyro_radps - bias_.gyro_radps;
  const Vec3 a = step.accel_mps2 - bias_.accel_mps2;
  const double dt = step.dt_s;
  const Mat3 E = so3_exp(w * dt);
  const Mat3 E_half = so3_exp(w * (0.5 * dt));
  const Mat3 Rm = dR_ * E_half;
  const Mat3 Rm_ax = Rm * skew(a);
  // Derivative of the mid-interval rotation by the gyro bias. With it the five Jacobians are the
  // exact derivatives of the sums below; with dRg_ in its place their error is O(dt).
  const Mat3 dRm_g = E_half.transpose() * dRg_ - so3_right_jacobian(w * (0.5 * dt)) * (0.5 * dt);

  propagate_covariance(E, E_half, Rm_ax, Rm, w, dt);

  // In this order: each line uses the values from before this sample.
  dpa_ += dva_ * dt - Rm * (0.5 * dt * dt);
  dpg_ += dvg_ * dt - Rm_ax * dRm_g * (0.5 * dt * dt);
  dva_ -= Rm * dt;
  dvg_ -= Rm_ax * dRm_g * dt;
  dRg_ = E.transpose() * dRg_ - so3_right_jacobian(w * dt) * dt;

  const Vec3 acc = Rm * a;
  dp_ += dv_ * dt + acc * (0.5 * dt * dt);
  dv_ += acc * dt;
  dR_ = dR_ * E;
  duration_s_ += dt;
}

void Preintegration::propagate_covariance(const Mat3& E, const Mat3& E_half, const Mat3& Rm_ax,
                                          const Mat3& Rm, const Vec3& w, double dt) {
  const double half_dt2 = 0.5 * dt * dt;
  const Mat3 turn = Rm_ax * E_half.transpose();
  Mat9 A = Mat9::Identity();
  A.block<3, 3>(0, 0) = E.transpose();
  A.block<3, 3>(3, 0) = -turn * dt;
  A.block<3, 3>(6, 0) = -turn * half_dt2;
  A.block<3, 3>(6, 3) = Mat3::Identity() * dt;

  const Mat3 half_turn = Rm_ax * so3_right_jacobian(w * (0.5 * dt)) * (0.5 * dt);
  Eigen::Matrix<double, 9, 3> Bg;
  Bg << so3_right_jacobian(w * dt) * dt, -half_turn * dt, -half_turn * half_dt2;
  Eigen::Matrix<double, 9, 3> Ba;
  Ba << Mat3::Zero(), Rm * dt, Rm * half_dt2;

  const double gyro_var = noise_.gyro_radps_rthz * noise_.gyro_radps_rthz / dt;
  const double accel_var = noise_.accel_mps2_rthz * noise_.accel_mps2_rthz / dt;
  const Mat9 P = A * covariance_ * A.transpose() + gyro_var * (Bg * Bg.transpose()) +
                 accel_var * (Ba * Ba.transpose());
  covariance_ = 0.5 * (P + P.transpose());
}

Mat3 Preintegration::delta_rotation(const InertialBias& bias) const {
  return dR_ * so3_exp(dRg_ * (bias.gyro_radps - bias_.gyro_radps));
}

Vec3 Preintegration::delta_velocity_mps(const InertialBias& bias) const {
  return dv_ + dvg_ * (bias.gyro_radps - bias_.gyro_radps) +
         dva_ * (bias.accel_mps2 - bias_.accel_mps2);
}

Vec3 Preintegration::delta_position_m(const InertialBias& bias) const {
  return dp_ + dpg_ * (bias.gyro_radps - bias_.gyro_radps) +
         dpa_ * (bias.accel_mps2 - bias_.accel_mps2);
}

InertialState Preintegration::predict(const InertialState& from, const Vec3& g_odom_mps2,
                                      const InertialBias& bias) const {
  const double D = duration_s_;
  InertialState to;
  to.R_odom_imu = geometry::so3_normalised(from.R_odom_imu * delta_rotation(bias));
  to.v_odom_mps = from.v_odom_mps + g_odom_mps2 * D + from.R_odom_imu * delta_velocity_mps(bias);
  to.p_odom_m = from.p_odom_m + from.v_odom_mps * D + g_odom_mps2 * (0.5 * D * D) +
                from.R_odom_imu * delta_position_m(bias);
  return to;
}

InertialResidual Preintegration::residual(const InertialState& i, const InertialState& j,
                                          const Vec3& g_odom_mps2, const InertialBias& bias) const {
  const double D = duration_s_;
  const Mat3 RiT = i.R_odom_imu.transpose();
  const Vec3 db_g = bias.gyro_radps - bias_.gyro_radps;
  const Vec3 velocity_i = RiT * (j.v_odom_mps - i.v_odom_mps - g_odom_mps2 * D);
  const Vec3 position_i =
      RiT * (j.p_odom_m - i.p_odom_m - i.v_odom_mps * D - g_odom_mps2 * (0.5 * D * D));
  const Vec3 r_R = so3_log(delta_rotation(bias).transpose() * RiT * j.R_odom_imu);
  const Mat3 JrInv = so3_right_jacobian_inverse(r_R);

  InertialResidual out;
  out.r << r_R, velocity_i - delta_velocity_mps(bias), position_i - delta_position_m(bias);
  out.d_pose_i.block<3, 3>(0, 0) = -JrInv * j.R_odom_imu.transpose() * i.R_odom_imu;
  out.d_pose_i.block<3, 3>(3, 0) = skew(velocity_i);
  out.d_pose_i.block<3, 3>(6, 0) = skew(position_i);
  out.d_pose_i.block<3, 3>(6, 3) = -RiT;
  out.d_pose_j.block<3, 3>(0, 0) = JrInv;
  out.d_pose_j.block<3, 3>(6, 3) = RiT;
  out.d_velocity_i.block<3, 3>(3, 0) = -RiT;
  out.d_velocity_i.block<3, 3>(6, 0) = -RiT * D;
  out.d_velocity_j.block<3, 3>(3, 0) = RiT;
  out.d_bias.block<3, 3>(0, 0) =
      -JrInv * so3_exp(r_R).transpose() * so3_right_jacobian(dRg_ * db_g) * dRg_;
  out.d_bias.block<3, 3>(3, 0) = -dvg_;
  out.d_bias.block<3, 3>(3, 3) = -dva_;
  out.d_bias.block<3, 3>(6, 0) = -dpg_;
  out.d_bias.block<3, 3>(6, 3) = -dpa_;
  return out;
}

}  // namespace rali::imu
