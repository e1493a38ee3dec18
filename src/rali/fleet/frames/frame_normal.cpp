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
/// By so much obstacles make a range longer: walls and racks in the way, or a path by way of a
/// wall. More is a contradiction.
constexpr double kObstructed_m = 3.0;
/// Of a range between vehicles that start poses relate: it costs at most the square of this. One
/// that is too long may have been measured through a wall, which happens to two in five: it says
/// little. None is too short for that reason.
constexpr double kBound_sigma = 5.0, kBoundLonger_sigma = 2.0;
/// Of all ranges that are too long in a row: what blocks the first blocks the next, so they are one
/// observation. It must exceed what a wrong start pose may cost.
constexpr double kBoundRow = 60.0;

Eigen::Index frame_at(std::size_t f) { return 4 * (static_cast<Eigen::Index>(f) - 1); }

struct Loss {
  double weight, cost;
};

/// Huber, or Geman-McClure with a bound. @param e predicted less measured, in sigma
Loss loss_of(double e, bool bounded, double knee) {
  if (bounded) {
    const double w = geometry::cauchy_weight(e, e < 0.0 ? kBoundLonger_sigma : kBound_sigma);
    return {w * w, w * e * e};
  }
  const double a = std::abs(e);
  return {geometry::huber_weight(e, knee), a <= knee ? e * e : 2.0 * knee * a - knee * knee};
}

Vec3 turned_back(double yaw_rad, const Vec3& v) {
  return YawPose{-yaw_rad, Vec3::Zero()}.turned(v);
}

/// Of (heading, position) of a compared body.
Vec4 path_error(const FrameProblem& problem, const FrameValues& v, std::size_t f,
                const Eigen::Matrix4Xd& drift) {
  if (drift.cols() == 0 || v.others.size() == 0) return Vec4::Zero();
  return drift * v.others.segment(problem.drift_at(f), drift.cols());
}

/// From b's body to the place where it saw a's: a heading error of b's body turns it.
Vec3 sight_m(const PoseEvidence& e) {
  return e.on_b ? Vec3(e.place_b_m - e.on_b->body.p_m) : Vec3(Vec3::Zero());
}

}  // namespace

Vec4 evidence_residual(const FrameProblem& problem, const FrameValues& v,
                       const EvidenceGroup& group, std::size_t k) {
  const PoseEvidence& e = group.alternatives[k];
  const YawPose& T_a = v.T_ref_odom[group.a[k]];
  const YawPose& T_b = v.T_ref_odom[group.b[k]];
  const Vec4 of_a = path_error(problem, v, group.a[k], group.a_drift[k]);
  const Vec4 of_b = path_error(problem, v, group.b[k], group.b_drift[k]);
  const Vec3 place_a_m = e.pivot_a_m + of_a.tail<3>();
  const Vec3 place_b_m = e.place_b_m + of_b.tail<3>() + of_b[0] * quarter_turn(sight_m(e));
  Vec4 r;
  r[0] = wrapped(T_a.yaw_rad + of_a[0] - T_b.yaw_rad - of_b[0] - e.yaw_rad);
  r.tail<3>() = T_b.inverse() * (T_a * place_a_m) - place_b_m;
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
  beyond_fit = obstructed = 0.0;
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
  std::swap(obstructed, other.obstructed);
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
  const bool longer = e < 0.0 && -e * r.sigma_m < kObstructed_m;
  if (longer) obstructed += std::max(0.0, loss.cost - 1.0);
  return loss.cost;
}

/// By more than 1.2 sigma. Of the present run, by number.
bool FrameNormal::is_too_long(std::size_t k) const {
  return residuals_[static_cast<Eigen::Index>(k)] < 0.0 &&
         costs_[k] > 0.25 * kBoundLonger_sigma * kBoundLonger_sigma;
}

/// Limits what ranges that are too long in a row cost together.
/// @return what the limit takes off the cost
double FrameNormal::limit_rows(const Run& run) {
  double saved = 0.0;
  for (std::size_t first = run.first; first < run.last;) {
    std::size_t last = first;
    double cost = 0.0;
    for (; last < run.last && is_too_long(last - run.first); ++last)
      cost += costs_[last - run.first];
    if (cost > kBoundRow) {
      const double fraction = kBoundRow / cost;
      const auto begin = static_cast<Eigen::Index>(first - run.first);
      const auto n = static_cast<Eigen::Index>(last - first);
      rows_.middleCols(begin, n) *= std::sqrt(fraction);
      residuals_.segment(begin, n) *= std::sqrt(fraction);
      saved += cost - kBoundRow;
    }
    first = std::max(last, first + 1);
  }
  return saved;
}

/// All ranges of a pair at once: a dense product is ten times as fast as scattered single updates.
double FrameNormal::add_run(const FrameValues& v, const Run& run) {
  const auto unknowns = static_cast<Eigen::Index>(run.at.size());
  const auto ranges = static_cast<Eigen::Index>(run.last - run.first);
  rows_.resize(unknowns, ranges);
  residuals_.resize(ranges);
  costs_.clear();
  double cost = 0.0;
  for (Eigen::Index k = 0; k < ranges; ++k) {
    const double own = write_row(v, p_.ranges[run.first + static_cast<std::size_t>(k)], k);
    beyond_fit += std::max(0.0, own - kMaxInFit);
    cost += own;
    costs_.push_back(own);
  }
  if (p_.ranges[run.first].bounded) cost -= limit_rows(run);
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

/// Unknowns of an alternative: yaw and position of a's frame and of b's, then the errors of both
/// paths; -1 for the first frame, which is fixed.
std::vector<Eigen::Index> FrameNormal::evidence_unknowns(const EvidenceGroup& group,
                                                         std::size_t k) const {
  std::vector<Eigen::Index> at;
  for (const std::size_t f : {group.a[k], group.b[k]}) {
    for (Eigen::Index i = 0; i < 4; ++i) at.push_back(f > 0 ? frame_at(f) + i : -1);
  }
  const auto append = [&at](Eigen::Index begin, Eigen::Index n) {
    for (Eigen::Index i = 0; i < n; ++i) at.push_back(begin + i);
  };
  append(drift_at_[group.a[k]], group.a_drift[k].cols());
  append(drift_at_[group.b[k]], group.b_drift[k].cols());
  return at;
}

/// Derivatives of the residual by evidence_unknowns().
Eigen::Matrix4Xd FrameNormal::evidence_slope(const FrameValues& v, const EvidenceGroup& group,
                                             std::size_t k) const {
  const PoseEvidence& e = group.alternatives[k];
  const Eigen::Matrix4Xd& a_drift = group.a_drift[k];
  const Eigen::Matrix4Xd& b_drift = group.b_drift[k];
  const YawPose& T_a = v.T_ref_odom[group.a[k]];
  const double yaw_b = v.T_ref_odom[group.b[k]].yaw_rad;
  const Vec3 place = T_a * Vec3(e.pivot_a_m + path_error(p_, v, group.a[k], a_drift).tail<3>());
  Eigen::Matrix4Xd J = Eigen::Matrix4Xd::Zero(4, 8 + a_drift.cols() + b_drift.cols());
  J(0, 0) = 1.0;
  J(0, 4) = -1.0;
  const Vec3 arm = place - T_a * p_.pivots_m[group.a[k]];
  J.block<3, 1>(1, 0) = turned_back(yaw_b, quarter_turn(arm));
  const Vec3 back = turned_back(yaw_b, place - v.T_ref_odom[group.b[k]] * p_.pivots_m[group.b[k]]);
  J.block<3, 1>(1, 4) = -quarter_turn(back);
  for (int c = 0; c < 3; ++c) {
    const Vec3 axis = turned_back(yaw_b, Vec3::Unit(c));
    J.block<3, 1>(1, 1 + c) = axis;
    J.block<3, 1>(1, 5 + c) = -axis;
  }
  for (Eigen::Index c = 0; c < a_drift.cols(); ++c) {
    J(0, 8 + c) = a_drift(0, c);
    J.block<3, 1>(1, 8 + c) = turned_back(yaw_b, T_a.turned(a_drift.col(c).tail<3>()));
  }
  J.rightCols(b_drift.cols()) = -b_drift;
  J.rightCols(b_drift.cols()).bottomRows<3>() -= quarter_turn(sight_m(e)) * b_drift.row(0);
  return J;
}

double FrameNormal::add_evidence(const FrameValues& v, const EvidenceGroup& group, std::size_t k) {
  const Mat4& information = group.alternatives[k].information;
  const Vec4 r = evidence_residual(p_, v, group, k);
  const Eigen::Matrix4Xd J = evidence_slope(v, group, k);
  const std::vector<Eigen::Index> at = evidence_unknowns(group, k);
  const Eigen::MatrixXd JJ = J.transpose() * information * J;
  const Eigen::VectorXd Jr = J.transpose() * (information * r);
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (at[i] < 0) continue;
    g[at[i]] += Jr[static_cast<Eigen::Index>(i)];
    for (std::size_t j = 0; j < at.size(); ++j) {
      if (at[j] >= 0) {
        H(at[i], at[j]) += JJ(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      }
    }
  }
  return r.dot(information * r);
}

}  // namespace rali::fleet
