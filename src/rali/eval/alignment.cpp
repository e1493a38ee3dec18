#include "rali/eval/alignment.hpp"

#include <cmath>

#include <Eigen/LU>
#include <Eigen/SVD>

namespace rali::eval {

using geometry::Mat3;
using geometry::SE3;
using geometry::Vec3;

namespace {

struct Moments {
  Vec3 mean_est = Vec3::Zero();
  Vec3 mean_ref = Vec3::Zero();
  Mat3 cross = Mat3::Zero();  ///< mean of (ref - mean_ref)(est - mean_est)'
};

Moments moments(const PairList& pairs) {
  Moments m;
  const double n = static_cast<double>(pairs.size());
  for (const PosePair& p : pairs) {
    m.mean_est += p.est.p / n;
    m.mean_ref += p.ref.p / n;
  }
  for (const PosePair& p : pairs) {
    m.cross += (p.ref.p - m.mean_ref) * (p.est.p - m.mean_est).transpose() / n;
  }
  return m;
}

Result<SE3> umeyama(const PairList& pairs) {
  const Moments m = moments(pairs);
  const Eigen::JacobiSVD<Mat3> svd(m.cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Vec3 d = svd.singularValues();
  // Rank below two: rotations about the line through the positions all fit equally well.
  if (!(d[1] > 1e-9 * d[0]) || !(d[0] > 0.0)) {
    return fail(ErrorCode::kNoAnswer, {},
                "the positions lie on one line or point, so their rotation is open",
                "Use alignment origin, or yaw if both frames are level.");
  }
  Vec3 sign(1.0, 1.0, 1.0);
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) sign.z() = -1.0;
  const Mat3 R = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  return SE3{R, m.mean_ref - R * m.mean_est};
}

Result<SE3> yaw_only(const PairList& pairs) {
  const Moments m = moments(pairs);
  // The best angle maximises trace(R' cross) over rotations about z.
  const double c = m.cross(0, 0) + m.cross(1, 1);
  const double s = m.cross(1, 0) - m.cross(0, 1);
  if (!(std::hypot(c, s) > 0.0)) {
    return fail(ErrorCode::kNoAnswer, {},
                "the positions do not move sideways, so their heading is open",
                "Use alignment origin.");
  }
  const Mat3 R = geometry::rotation_from_rpy(0.0, 0.0, std::atan2(s, c));
  return SE3{R, m.mean_ref - R * m.mean_est};
}

}  // namespace

Result<SE3> align(const PairList& pairs, Alignment how) {
  if (pairs.empty()) return fail(ErrorCode::kNoAnswer, {}, "there are no poses to align");
  switch (how) {
    case Alignment::kNone:
      return SE3{};
    case Alignment::kOrigin:
      return pairs.front().ref * pairs.front().est.inverse();
    case Alignment::kSe3:
      return umeyama(pairs);
    case Alignment::kYaw:
      return yaw_only(pairs);
  }
  return SE3{};
}

}  // namespace rali::eval
