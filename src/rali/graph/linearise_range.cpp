// The range factor: both ends, bias and time offset (algorithms 4.1, algorithms_fleet 8.1).
#include "rali/base/assert.hpp"
#include "rali/geometry/robust.hpp"
#include "rali/graph/linearise.hpp"

namespace rali::graph {

using geometry::Vec3;

namespace {

// At a smaller distance the direction between two antennas is rounding.
constexpr double kDirectionMinM = 1e-6;

const GlobalNode& value(const Window& window, GlobalId id) {
  const int g = window.find(id);
  RALI_ASSERT(g >= 0);
  return window.globals[static_cast<std::size_t>(g)];
}

// Position and velocity of an end, and its columns.
struct Antenna {
  Vec3 p_m = Vec3::Zero();
  Vec3 v_mps = Vec3::Zero();
  int ci = -1;
  int cj = -1;
};

Antenna antenna(const Window& window, const RangeEnd& end, bool with_velocity, LinearFactor& out) {
  Antenna at;
  const auto columns = [&](const KeyframeNode& node) {
    RALI_ASSERT(!with_velocity || node.dim > kPoseDim);
    return out.append(window.column(node.seq), with_velocity ? kVel + 3 : kPoseDim);
  };
  const double wi = 1.0 - end.alpha;
  const KeyframeNode& i = window.node(end.i);
  at.p_m = wi * (i.x.T_odom_body * end.p_i_m);
  at.v_mps = wi * i.x.v_odom_mps;
  at.ci = columns(i);
  if (!end.j) return at;
  const KeyframeNode& j = window.node(*end.j);
  at.p_m += end.alpha * (j.x.T_odom_body * end.p_j_m);
  at.v_mps += end.alpha * j.x.v_odom_mps;
  at.cj = columns(j);
  return at;
}

// Derivatives of the range by position and velocity of the antenna at this end.
struct Slopes {
  Vec3 d_p = Vec3::Zero();
  bool with_velocity = false;
  double tau = 0.0;
  Vec3 e = Vec3::Zero();  ///< direction; d/d(velocity) = tau e
};

// `sign` is -1 for the other end.
void fill(const Window& window, const RangeEnd& end, const Antenna& at, double sign,
          const Slopes& slopes, LinearFactor& out) {
  const auto node = [&](int column, double w, Seq seq, const Vec3& p_body) {
    const geometry::Mat3& R = window.node(seq).x.T_odom_body.R;
    out.J.block<1, 3>(0, column + kTheta) =
        -w * slopes.d_p.transpose() * R * geometry::skew(p_body);
    out.J.block<1, 3>(0, column + kPos) = w * slopes.d_p.transpose();
    if (slopes.with_velocity) {
      out.J.block<1, 3>(0, column + kVel) = w * slopes.tau * slopes.e.transpose();
    }
  };
  node(at.ci, sign * (1.0 - end.alpha), end.i, end.p_i_m);
  if (end.j) node(at.cj, sign * end.alpha, *end.j, end.p_j_m);
}

}  // namespace

void range_residual(const Window& window, const RangeFactor& f, LinearFactor& out) {
  out.start(1);
  // Without a given rate the range depends on the velocity, and on the position through e as well.
  const bool own_rate = f.tau && !f.range_rate_mps;
  const Antenna from = antenna(window, f, own_rate, out);
  Antenna to;
  if (f.other) {
    to = antenna(window, *f.other, own_rate, out);
  } else {
    to.p_m = f.landmark ? value(window, landmark_id(*f.landmark)).value : f.p_fixed_odom_m;
  }
  const Vec3 h = from.p_m - to.p_m;
  const Vec3 v = from.v_mps - to.v_mps;
  const double rho = h.norm();
  const Vec3 e = rho > kDirectionMinM ? Vec3(h / rho) : Vec3::Zero();
  const double rate = f.range_rate_mps ? *f.range_rate_mps : e.dot(v);
  const double tau = f.tau ? value(window, tau_id(*f.tau)).value.x() : 0.0;
  const Vec3 d_p = own_rate && rho > kDirectionMinM ? Vec3(e + tau / rho * (v - rate * e)) : e;
  const Slopes slopes{d_p, own_rate, tau, e};
  fill(window, f, from, 1.0, slopes, out);
  double bias = 0.0;
  if (f.other) {
    fill(window, *f.other, to, -1.0, slopes, out);
  } else if (f.landmark) {
    const int c = out.append(window.column(landmark_id(*f.landmark)), 3);
    out.J.block<1, 3>(0, c) = -slopes.d_p.transpose();
  }
  if (f.bias) {
    bias = value(window, bias_id(*f.bias)).value.x();
    out.J(0, out.append(window.column(bias_id(*f.bias)), 1)) = 1.0;
  }
  if (f.tau) out.J(0, out.append(window.column(tau_id(*f.tau)), 1)) = rate;
  out.r(0) = rho + bias + tau * rate - f.range_m;
  out.finish();
}

void linearise(const Window& window, const RangeFactor& f, double huber_sd, LinearFactor& out) {
  range_residual(window, f, out);
  const double scale = std::sqrt(f.weight) / f.sigma_m;
  const double z = scale * out.r(0);
  const double root = std::sqrt(geometry::huber_weight(z, huber_sd));
  out.J *= scale * root;
  out.r(0) = z * root;
  const double a = std::abs(z);
  out.cost = a <= huber_sd ? 0.5 * z * z : huber_sd * (a - 0.5 * huber_sd);
}

}  // namespace rali::graph
