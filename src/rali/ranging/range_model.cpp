#include "rali/ranging/range_model.hpp"

#include <algorithm>
#include <cmath>

namespace rali::ranging {

using geometry::Vec3;

namespace {

/// d rho / d theta of an end whose antenna direction is e: -e^T R [l]x = (l x R^T e)^T.
RangePrediction::Row3 turn_effect(const RangeEnd& end, const Vec3& e) {
  return end.p_body_antenna_m.cross(end.T_odom_body.R.transpose() * e).transpose();
}

/// All of the prediction but the derivative by the rotation of the far end.
std::optional<RangePrediction> predict_to(const RangeEnd& j, const Vec3& antenna_k,
                                          const Vec3& v_antenna_k, double near_m) {
  const Vec3 h = j.antenna_odom_m() - antenna_k;
  RangePrediction out;
  out.rho_m = h.norm();
  // Written so that NaN is refused as well.
  if (!(out.rho_m >= near_m && out.rho_m > 0.0) || !std::isfinite(out.rho_m)) return std::nullopt;
  out.e = h / out.rho_m;
  out.d_theta_j = turn_effect(j, out.e);
  out.d_p_j = out.e.transpose();
  out.d_p_k = -out.e.transpose();
  out.rate_mps = out.e.dot(j.antenna_v_odom_mps() - v_antenna_k);
  return out;
}

}  // namespace

std::optional<RangePrediction> predict(const RangeEnd& j, const RangeEnd& k, double near_m) {
  std::optional<RangePrediction> out =
      predict_to(j, k.antenna_odom_m(), k.antenna_v_odom_mps(), near_m);
  if (out) out->d_theta_k = -turn_effect(k, out->e);
  return out;
}

std::optional<RangePrediction> predict(const RangeEnd& j, const Vec3& p_odom_antenna_k_m,
                                       double near_m) {
  return predict_to(j, p_odom_antenna_k_m, Vec3::Zero(), near_m);
}

double sigma_of(double range_m, const RangeLimits& limits, double sample_sigma_m) {
  if (std::isfinite(sample_sigma_m) && sample_sigma_m > 0.0) {
    return std::max(sample_sigma_m, limits.sigma_min_m);
  }
  return std::hypot(limits.sigma_m, limits.sigma_per_m * range_m);
}

}  // namespace rali::ranging
