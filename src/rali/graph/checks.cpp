#include "rali/graph/checks.hpp"

#include <algorithm>
#include <cmath>

#include "rali/base/assert.hpp"
#include "rali/graph/root.hpp"

namespace rali::graph {

namespace {

bool finite(const InertialFactor& f) {
  return f.dR.allFinite() && f.dv_mps.allFinite() && f.dp_m.allFinite() &&
         f.gyro_bias_radps.allFinite() && f.accel_bias_mps2.allFinite() &&
         f.d_rotation_d_gyro.allFinite() && f.d_velocity_d_gyro.allFinite() &&
         f.d_velocity_d_accel.allFinite() && f.d_position_d_gyro.allFinite() &&
         f.d_position_d_accel.allFinite() && f.g_odom_mps2.allFinite() &&
         graph::finite(f.T_body_imu);
}

bool contains(const Window& window, Seq seq) { return window.find(seq) >= 0; }

void check(const Window& window, const RangeEnd& end) {
  RALI_ASSERT(contains(window, end.i));
  RALI_ASSERT(!end.j || (contains(window, *end.j) && *end.j != end.i));
  RALI_ASSERT(end.alpha >= 0.0 && end.alpha <= 1.0 && (end.j || end.alpha == 0.0));
  RALI_ASSERT(end.p_i_m.allFinite() && end.p_j_m.allFinite());
}

}  // namespace

bool finite(const geometry::SE3& T) { return T.R.allFinite() && T.p.allFinite(); }

bool finite(const KeyframeState& x) {
  return finite(x.T_odom_body) && x.v_odom_mps.allFinite() && x.gyro_bias_radps.allFinite() &&
         x.accel_bias_mps2.allFinite();
}

bool positive(double sigma) { return std::isfinite(sigma) && sigma > 0.0; }

void check(const Window& window, const RangeFactor& f) {
  check(window, static_cast<const RangeEnd&>(f));
  if (f.other) {
    check(window, *f.other);
    RALI_ASSERT(!f.landmark);
    // With the same node at both ends the range would not constrain any pose.
    const auto apart = [&](Seq seq) { return seq != f.i && (!f.j || seq != *f.j); };
    RALI_ASSERT(apart(f.other->i) && (!f.other->j || apart(*f.other->j)));
  }
  RALI_ASSERT(!f.landmark || window.find(landmark_id(*f.landmark)) >= 0);
  RALI_ASSERT(!f.bias || window.find(bias_id(*f.bias)) >= 0);
  RALI_ASSERT(!f.tau || window.find(tau_id(*f.tau)) >= 0);
  RALI_ASSERT(f.p_fixed_odom_m.allFinite());
  RALI_ASSERT(!f.range_rate_mps || std::isfinite(*f.range_rate_mps));
  RALI_ASSERT(std::isfinite(f.range_m) && positive(f.sigma_m));
  RALI_ASSERT(std::isfinite(f.weight) && f.weight >= 0.0);
}

void check(const Window& window, const StandstillFactor& f) {
  RALI_ASSERT(contains(window, f.i) && (!f.next || (contains(window, *f.next) && *f.next != f.i)));
  RALI_ASSERT(f.next || window.node(f.i).dim > kPoseDim);
  RALI_ASSERT(positive(f.sigma_mps) && positive(f.sigma_m) && positive(f.sigma_rad));
}

InertialTerm with_root(const Window& window, const InertialFactor& f) {
  RALI_ASSERT(contains(window, f.i) && contains(window, f.j) && f.i != f.j);
  RALI_ASSERT(window.node(f.i).dim == kStateDim && window.node(f.j).dim == kStateDim);
  RALI_ASSERT(finite(f));
  RALI_ASSERT(positive(f.duration_s) && positive(f.gyro_walk_radps_rts) &&
              positive(f.accel_walk_mps2_rts));
  return {f, covariance_root(f.covariance)};
}

RelativeTerm with_root(const Window& window, const RelativePoseFactor& f) {
  RALI_ASSERT(contains(window, f.i) && contains(window, f.j) && f.i != f.j);
  RALI_ASSERT(finite(f.T_i_j));
  return {f, information_root(f.information)};
}

PriorTerm with_root(const Window& window, const PriorFactor& f) {
  RALI_ASSERT(contains(window, f.i) && finite(f.mean));
  StateMat information = f.information;
  const int dim = window.node(f.i).dim;
  information.rightCols(kStateDim - dim).setZero();
  information.bottomRows(kStateDim - dim).setZero();
  return {f, information_root(information)};
}

void insert_global(Window& window, GlobalId id, const geometry::Vec3& mean,
                   const geometry::Mat3& information) {
  RALI_ASSERT(window.find(id) < 0);
  RALI_ASSERT(mean.allFinite() && information.allFinite());
  GlobalNode node;
  node.id = id;
  node.value = mean;
  node.prior_mean = mean;
  node.prior_information = information;
  const auto place =
      std::lower_bound(window.globals.begin(), window.globals.end(), id,
                       [](const GlobalNode& global, GlobalId other) { return global.id < other; });
  window.globals.insert(place, node);
}

void insert_landmark(Window& window, int number, const geometry::Vec3& p_odom_m,
                     const geometry::Mat3& covariance) {
  const Eigen::MatrixXd root = covariance_root(covariance);
  insert_global(window, landmark_id(number), p_odom_m, root.transpose() * root);
}

void insert_scalar(Window& window, GlobalId id, double mean, double sigma) {
  RALI_ASSERT(positive(sigma));
  insert_global(window, id, {mean, 0.0, 0.0},
                geometry::Vec3(1.0 / (sigma * sigma), 0.0, 0.0).asDiagonal());
}

}  // namespace rali::graph
