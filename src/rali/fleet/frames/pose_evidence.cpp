#include "rali/fleet/frames/pose_evidence.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace rali::fleet {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;

namespace {

Mat4 diagonal_information(double yaw_sigma_rad, double place_sigma_m) {
  Vec4 v = Vec4::Constant(1.0 / (place_sigma_m * place_sigma_m));
  v[0] = 1.0 / (yaw_sigma_rad * yaw_sigma_rad);
  return v.asDiagonal();
}

}  // namespace

YawPose PoseEvidence::T_b_a() const {
  YawPose T{yaw_rad, Vec3::Zero()};
  T.t_m = place_b_m - T.turned(pivot_a_m);
  return T;
}

PoseEvidence prior_evidence(StreamKey a, StreamKey b, const YawPose& T_b_a,
                            const InitSettings& settings) {
  PoseEvidence e;
  e.a = a;
  e.b = b;
  e.yaw_rad = T_b_a.yaw_rad;
  e.place_b_m = T_b_a.t_m;
  e.information = diagonal_information(settings.prior.yaw_deg * kDegree, settings.prior.xyz_m);
  e.source = EvidenceSource::kPrior;
  e.wrong_chi2 = settings.prior.wrong_chi2;
  return e;
}

PoseEvidence keyframe_evidence(StreamKey a, StreamKey b, const SE3& T_odoma_ka,
                               const SE3& T_odomb_kb, const SE3& T_kb_ka, const Mat6& information,
                               const InitSettings& settings) {
  PoseEvidence e;
  e.a = a;
  e.b = b;
  e.wrong_chi2 = settings.scan2map.wrong_chi2;
  const SE3 T_odomb_ka = T_odomb_kb * T_kb_ka;
  e.yaw_rad = YawPose::of(T_odomb_ka * T_odoma_ka.inverse()).yaw_rad;
  e.pivot_a_m = T_odoma_ka.p;
  e.place_b_m = T_odomb_ka.p;
  // Rotation about b's axes and position in b: R_b_ka theta and R_b_kb rho.
  Mat6 G = Mat6::Zero();
  G.topLeftCorner<3, 3>() = T_odomb_ka.R;
  G.bottomRightCorner<3, 3>() = T_odomb_kb.R;
  const Mat6 I = G * information * G.transpose();
  // Marginalises roll and pitch: they have their own prior, so the result is regular.
  const double tilt = std::max(settings.drift.tilt_deg, 0.01) * kDegree;
  Eigen::Matrix2d I_tilt = I.topLeftCorner<2, 2>();
  I_tilt.diagonal().array() += 1.0 / (tilt * tilt);
  const Eigen::Matrix<double, 4, 2> I_cross = I.bottomLeftCorner<4, 2>();
  e.information = I.bottomRightCorner<4, 4>() - I_cross * I_tilt.ldlt().solve(I_cross.transpose());
  e.information = Mat4(0.5 * (e.information + e.information.transpose()));
  return e;
}

}  // namespace rali::fleet
