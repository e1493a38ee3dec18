#include "rali/fleet/frames/frame_normal.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "rali/geometry/robust.hpp"

namespace rali::fleet {

using geometry::Vec3;

namespace {

/// Two ends at the same point have no direction.
constexpr double kMinDistance_m = 1e-6;
/// A range along a blocked path is no measure of the fit of the others: one in ten of them must not
/// make a correct solution look like a misfit.
constexpr double kMaxInFit = 9.0;
/// Of a range between vehicles that start poses relate: it costs at most the square of this.
constexpr double kBound_sigma = 5.0;

Eigen::Index frame_at(std::size_t f) { return 4 * (static_cast<Eigen::Index>(f) - 1); }

struct Loss {
  double weight, cost;
};

/// Huber, or Geman-McClure with a bound. @param e in sigma
Loss loss_of(double e, bool bounded, double knee) {
  if (bounded) {
    const double w = geometry::cauchy_weight(e, kBound_sigma);
    return {w * w, w * e * e};
  }
  const double a = std::abs(e);
  return {geometry::huber_weight(e, knee), a <= knee ? e * e : 2.0 * knee * a - knee * knee};
}

Vec3 turned_back(double yaw_rad, const Vec3& v) {
  return YawPose{-yaw_rad, Vec3::Zero()}.turned(v);
}

}  // namespace

Vec4 evidence_residual(const FrameValues& v, const EvidenceGroup& group, std::size_t k) {
  const PoseEvidence& e = group.alternatives[k];
  const YawPose& T_a = v.T_ref_odom[group.a[k]];
  const YawPose& T_b = v.T_ref_odom[group.b[k]];
  Vec4 r;
  r[0] = wrapped(T_a.yaw_rad - T_b.yaw_rad - e.yaw_rad);
  r.tail<3>() = T_b.inverse() * (T_a * e.pivot_a_m) - e.place_b_m;
  return r;
}

FrameNormal::FrameNormal(const FrameProblem& problem) : p_(problem) {
  Eigen::Index at = p_.frame_size() + p_.bias_size();
  for (const Eigen::Index n : p_.drifts) {
    drift_at_.push_back(at);
    at += n;
  }
  H.resize(p_.size(), p_.size());
  g.resize(p_.size());
  runs_ = runs();
}

std::vector<FrameNormal::Run> FrameNormal::runs() const {
  std::vector<Run> out;
  for (std::size_t first = 0; first < p_.ranges.size(); first = out.back().last) {
    const RangeTerm& r = p_.ranges[first];
    Run run{first, first + 1, {}};
    while (run.last < p_.ranges.size() && p_.ranges[run.last].pair == r.pair) ++run.last;
    const auto append = [&run](Eigen::Index begin, Eigen::Index n) {
      for (Eigen::Index k = 0; k < n; ++k) run.at.push_back(begin + k);
    };
    for (const std::size_t f : {r.a, r.b}) {
      if (f > 0) append(frame_at(f), 4);
      append(drift_at_[f], p_.drifts[f]);
    }
    if (p_.bias_size() > 0) append(p_.frame_size() + static_cast<Eigen::Index>(r.pair), 1);
    out.push_back(std::move(run));
  }
  return out;
}

FrameValues FrameNormal::moved(const FrameValues& v, const Eigen::VectorXd& d) const {
  FrameValues out = v;
  for (std::size_t f = 1; f < p_.keys.size(); ++f) {
    const Eigen::Index at = frame_at(f);
    const Vec3 place = v.T_ref_odom[f] * p_.pivots_m[f] + d.segment<3>(at + 1);
    YawPose& T = out.T_ref_odom[f];
    T.yaw_rad = wrapped(T.yaw_rad + d[at]);
    T.t_m = place - T.turned(p_.pivots_m[f]);
  }
  out.others += d.tail(out.others.size());
  return out;
}

double FrameNormal::build(const FrameValues& v, const std::vector<int>& holds) {
  beyond_fit = 0.0;
  double cost = build_evidence(v, holds) + add_priors(v);
  set_frames(v);
  for (const Run& run : runs_) cost += add_run(v, run);
  return cost;
}

double FrameNormal::build_evidence(const FrameValues& v, const std::vector<int>& holds) {
  H.setZero();
  g.setZero();
  double cost = 0.0;
  for (std::size_t k = 0; k < p_.evidence.size(); ++k) {
    if (holds[k] >= 0) cost += add_evidence(v, p_.evidence[k], static_cast<std::size_t>(holds[k]));
  }
  return cost;
}

void FrameNormal::swap(FrameNormal& other) {
  std::swap(H, other.H);
  std::swap(g, other.g);
  std::swap(beyond_fit, other.beyond_fit);
}

double FrameNormal::add_priors(const FrameValues& v) {
  const double z_weight = 1.0 / (p_.settings.z_sigma_m * p_.settings.z_sigma_m);
  double cost = 0.0;
  for (std::size_t f = 1; f < p_.keys.size(); ++f) {
    const double z = v.T_ref_odom[f].t_m.z();
    H(frame_at(f) + 3, frame_at(f) + 3) += z_weight;
    g[frame_at(f) + 3] += z_weight * z;
    cost += z_weight * z * z;
  }
  for (Eigen::Index k = 0; k < v.others.size(); ++k) {
    const bool is_bias = k < p_.bias_size();
    const double weight =
        is_bias ? 1.0 / (p_.settings.bias_sigma_m * p_.settings.bias_sigma_m) : 1.0;
    const Eigen::Index at = p_.frame_size() + k;
    H(at, at) += weight;
    g[at] += weight * v.others[k];
    cost += weight * v.others[k] * v.others[k];
  }
  return cost;
}

void FrameNormal::set_frames(const FrameValues& v) {
  frames_.resize(v.T_ref_odom.size());
  for (std::size_t f = 0; f < frames_.size(); ++f) {
    const YawPose& T = v.T_ref_odom[f];
    frames_[f] = {std::cos(T.yaw_rad), std::sin(T.yaw_rad), T.t_m, T * p_.pivots_m[f]};
  }
}

/// The end's position in the first frame.
Vec3 FrameNormal::place_of(const FrameValues& v, std::size_t f, const Vec3& x,
                           const Eigen::Matrix3Xd& drift) const {
  Vec3 moved_m = x;
  if (drift.cols() > 0) {
    const Eigen::Index from = drift_at_[f] - p_.frame_size();
    moved_m += drift * v.others.segment(from, drift.cols());
  }
  const Placed& T = frames_[f];
  return T.t_m + Vec3(T.cos_yaw * moved_m.x() - T.sin_yaw * moved_m.y(),
                      T.sin_yaw * moved_m.x() + T.cos_yaw * moved_m.y(), moved_m.z());
}

/// Derivatives of the distance between two ends by the unknowns of one of them: yaw and position of
/// its frame, unless that is the first one, then the errors of its path.
/// @param u towards this end, with the row's weight @return where to continue writing
double* FrameNormal::write_end(std::size_t f, const Vec3& place_m, const Eigen::Matrix3Xd& drift,
                               const Vec3& u, double* out) const {
  const Placed& T = frames_[f];
  if (f > 0) {
    *out++ = u.dot(quarter_turn(place_m - T.pivot_m));
    for (int k = 0; k < 3; ++k) *out++ = u[k];
  }
  const Vec3 u_own(T.cos_yaw * u.x() + T.sin_yaw * u.y(), T.cos_yaw * u.y() - T.sin_yaw * u.x(),
                   u.z());
  for (Eigen::Index k = 0; k < drift.cols(); ++k) *out++ = u_own.dot(drift.col(k));
  return out;
}

/// Residual and derivatives of one range, weighted by its sigma and its loss. @return cost
double FrameNormal::write_row(const FrameValues& v, const RangeTerm& r, Eigen::Index row) {
  const Vec3 place_a = place_of(v, r.a, r.x_m, r.x_drift);
  const Vec3 place_b = place_of(v, r.b, r.y_m, r.y_drift);
  const Vec3 apart = place_a - place_b;
  const double rho = std::max(apart.norm(), kMinDistance_m);
  const Vec3 u = apart / rho;
  const bool biased = p_.bias_size() > 0;
  const double bias_m = biased ? v.others[static_cast<Eigen::Index>(r.pair)] : 0.0;
  const double e = (rho + bias_m - r.range_m) / r.sigma_m;
  const Loss loss = loss_of(e, r.bounded, p_.settings.search.huber);
  const double root = std::sqrt(loss.weight);
  const double scale = root / r.sigma_m;
  double* out = rows_.col(row).data();
  out = write_end(r.a, place_a, r.x_drift, scale * u, out);
  out = write_end(r.b, place_b, r.y_drift, -scale * u, out);
  if (biased) *out = scale;
  residuals_[row] = root * e;
  return loss.cost;
}

/// All ranges of a pair at once: a dense product is ten times as fast as scattered single updates.
double FrameNormal::add_run(const FrameValues& v, const Run& run) {
  const auto unknowns = static_cast<Eigen::Index>(run.at.size());
  const auto ranges = static_cast<Eigen::Index>(run.last - run.first);
  rows_.resize(unknowns, ranges);
  residuals_.resize(ranges);
  double cost = 0.0;
  for (Eigen::Index k = 0; k < ranges; ++k) {
    const double own = write_row(v, p_.ranges[run.first + static_cast<std::size_t>(k)], k);
    beyond_fit += std::max(0.0, own - kMaxInFit);
    cost += own;
  }
  squares_.setZero(unknowns, unknowns);
  squares_.selfadjointView<Eigen::Lower>().rankUpdate(rows_);
  slope_.noalias() = rows_ * residuals_;
  for (Eigen::Index i = 0; i < unknowns; ++i) {
    const Eigen::Index to = run.at[static_cast<std::size_t>(i)];
    g[to] += slope_[i];
    H(to, to) += squares_(i, i);
    for (Eigen::Index j = 0; j < i; ++j) {
      const Eigen::Index other = run.at[static_cast<std::size_t>(j)];
      H(to, other) += squares_(i, j);
      H(other, to) += squares_(i, j);
    }
  }
  return cost;
}

double FrameNormal::add_evidence(const FrameValues& v, const EvidenceGroup& group, std::size_t k) {
  const PoseEvidence& e = group.alternatives[k];
  const std::size_t a = group.a[k];
  const std::size_t b = group.b[k];
  const Vec4 r = evidence_residual(v, group, k);
  const double yaw_b = v.T_ref_odom[b].yaw_rad;
  const Vec3 place = v.T_ref_odom[a] * e.pivot_a_m;
  Eigen::Matrix<double, 4, 8> J = Eigen::Matrix<double, 4, 8>::Zero();
  J(0, 0) = 1.0;
  J(0, 4) = -1.0;
  const Vec3 arm = place - v.T_ref_odom[a] * p_.pivots_m[a];
  J.block<3, 1>(1, 0) = turned_back(yaw_b, quarter_turn(arm));
  const Vec3 back = turned_back(yaw_b, place - v.T_ref_odom[b] * p_.pivots_m[b]);
  J.block<3, 1>(1, 4) = -quarter_turn(back);
  for (int c = 0; c < 3; ++c) {
    const Vec3 axis = turned_back(yaw_b, Vec3::Unit(c));
    J.block<3, 1>(1, 1 + c) = axis;
    J.block<3, 1>(1, 5 + c) = -axis;
  }
  const Eigen::Matrix<double, 8, 8> JJ = J.transpose() * e.information * J;
  const Eigen::Matrix<double, 8, 1> Jr = J.transpose() * (e.information * r);
  const auto scatter = [&](std::size_t f, std::size_t h, Eigen::Index i, Eigen::Index j) {
    if (f > 0 && h > 0) H.block<4, 4>(frame_at(f), frame_at(h)) += JJ.block<4, 4>(i, j);
  };
  scatter(a, a, 0, 0);
  scatter(a, b, 0, 4);
  scatter(b, a, 4, 0);
  scatter(b, b, 4, 4);
  if (a > 0) g.segment<4>(frame_at(a)) += Jr.head<4>();
  if (b > 0) g.segment<4>(frame_at(b)) += Jr.tail<4>();
  return r.dot(e.information * r);
}

}  // namespace rali::fleet
