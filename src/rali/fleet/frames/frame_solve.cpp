#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "rali/fleet/frames/frame_problem.hpp"
#include "rali/geometry/robust.hpp"

namespace rali::fleet {

using geometry::Vec3;

namespace {

/// A pair that lies in one point has no direction.
constexpr double kLeastDistance_m = 1e-6;
/// Keeps directions of which nothing is known where they are.
constexpr double kTinyInformation = 1e-6;
/// An eigenvalue below this share of the largest is none: nothing is known along it.
constexpr double kNothing = 1e-9;
/// A range whose direct way was blocked tells nothing about the fit of the others: one in ten of
/// them must not make a good answer look like none.
constexpr double kMostInFit = 9.0;
constexpr double kConverged = 1e-9;
constexpr double kEasier = 0.1, kHarder = 10.0, kLeastDamping = 1e-9, kMostDamping = 1e8;
/// Times that the alternatives are chosen anew: two choices could take turns.
constexpr int kChoices = 4;

Vec3 turned_back(double yaw_rad, const Vec3& v) {
  return YawPose{-yaw_rad, Vec3::Zero()}.turned(v);
}

/// Normal equations of a problem at given values.
class Normal {
 public:
  explicit Normal(const FrameProblem& problem) : p_(problem) {
    Eigen::Index at = p_.frame_size() + p_.bias_size();
    for (const Eigen::Index n : p_.drifts) {
      drift_at_.push_back(at);
      at += n;
    }
    H.resize(p_.size(), p_.size());
    g.resize(p_.size());
  }

  /// Values plus step d.
  [[nodiscard]] FrameValues moved(const FrameValues& v, const Eigen::VectorXd& d) const {
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

  /// @return cost: robust squares of all
  double build(const FrameValues& v, const std::vector<int>& holds) {
    H.setZero();
    g.setZero();
    beyond_fit = 0.0;
    double cost = add_priors(v);
    for (const RangeTerm& r : p_.ranges) cost += add_range(v, r);
    for (std::size_t k = 0; k < p_.evidence.size(); ++k) {
      if (holds[k] >= 0)
        cost += add_evidence(v, p_.evidence[k], static_cast<std::size_t>(holds[k]));
    }
    return cost;
  }

  /// Only what evidence adds.
  void build_evidence(const FrameValues& v, const std::vector<int>& holds) {
    H.setZero();
    g.setZero();
    for (std::size_t k = 0; k < p_.evidence.size(); ++k) {
      if (holds[k] >= 0) add_evidence(v, p_.evidence[k], static_cast<std::size_t>(holds[k]));
    }
  }

  [[nodiscard]] static Vec4 evidence_residual(const FrameValues& v, const EvidenceGroup& group,
                                              std::size_t k) {
    const PoseEvidence& e = group.alternatives[k];
    const YawPose& T_a = v.T_ref_odom[group.a[k]];
    const YawPose& T_b = v.T_ref_odom[group.b[k]];
    Vec4 r;
    r[0] = wrapped(T_a.yaw_rad - T_b.yaw_rad - e.yaw_rad);
    r.tail<3>() = T_b.inverse() * (T_a * e.pivot_a_m) - e.place_b_m;
    return r;
  }

  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  double beyond_fit = 0.0;  ///< part of the cost that the fit is not judged by

 private:
  [[nodiscard]] static Eigen::Index frame_at(std::size_t f) {
    return 4 * (static_cast<Eigen::Index>(f) - 1);
  }

  double add_priors(const FrameValues& v) {
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

  /// The end's place in the first frame; writes the derivatives of u.place into the row.
  Vec3 place_of(const FrameValues& v, std::size_t f, const Vec3& x, const Eigen::Matrix3Xd& drift) {
    Vec3 moved_m = x;
    if (drift.cols() > 0) {
      const Eigen::Index from = drift_at_[f] - p_.frame_size();
      moved_m += drift * v.others.segment(from, drift.cols());
    }
    return v.T_ref_odom[f] * moved_m;
  }

  void put(Eigen::Index at, double value) {
    at_.push_back(at);
    row_.push_back(value);
  }

  void add_end(const FrameValues& v, std::size_t f, const Vec3& place,
               const Eigen::Matrix3Xd& drift, const Vec3& u) {
    if (f > 0) {
      const Vec3 arm = place - v.T_ref_odom[f] * p_.pivots_m[f];
      put(frame_at(f), u.dot(quarter_turn(arm)));
      for (int k = 0; k < 3; ++k) put(frame_at(f) + 1 + k, u[k]);
    }
    const Vec3 u_own = turned_back(v.T_ref_odom[f].yaw_rad, u);
    for (Eigen::Index k = 0; k < drift.cols(); ++k) put(drift_at_[f] + k, u_own.dot(drift.col(k)));
  }

  double add_range(const FrameValues& v, const RangeTerm& r) {
    const Vec3 place_a = place_of(v, r.a, r.x_m, r.x_drift);
    const Vec3 place_b = place_of(v, r.b, r.y_m, r.y_drift);
    const Vec3 apart = place_a - place_b;
    const double rho = std::max(apart.norm(), kLeastDistance_m);
    const Vec3 u = apart / rho;
    at_.clear();
    row_.clear();
    add_end(v, r.a, place_a, r.x_drift, u);
    add_end(v, r.b, place_b, r.y_drift, -u);
    double bias_m = 0.0;
    if (p_.bias_size() > 0) {
      const auto at = static_cast<Eigen::Index>(r.pair);
      bias_m = v.others[at];
      put(p_.frame_size() + at, 1.0);
    }
    const double e = (rho + bias_m - r.range_m) / r.sigma_m;
    const double weight = geometry::huber_weight(e, p_.settings.search.huber);
    const double scale = weight / (r.sigma_m * r.sigma_m);
    for (std::size_t i = 0; i < at_.size(); ++i) {
      g[at_[i]] += weight * e * row_[i] / r.sigma_m;
      const double s = scale * row_[i];
      for (std::size_t j = 0; j < at_.size(); ++j) H(at_[j], at_[i]) += s * row_[j];
    }
    const double knee = p_.settings.search.huber;
    const double cost = std::abs(e) <= knee ? e * e : 2.0 * knee * std::abs(e) - knee * knee;
    beyond_fit += std::max(0.0, cost - kMostInFit);
    return cost;
  }

  double add_evidence(const FrameValues& v, const EvidenceGroup& group, std::size_t k) {
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

  const FrameProblem& p_;
  std::vector<Eigen::Index> drift_at_;
  std::vector<Eigen::Index> at_;
  std::vector<double> row_;
};

/// Frames' part of H with the first `integrated` of the other unknowns integrated out and the rest
/// held.
Eigen::MatrixXd marginal(const Eigen::MatrixXd& H, Eigen::Index frames, Eigen::Index integrated) {
  Eigen::MatrixXd out = H.topLeftCorner(frames, frames);
  if (integrated > 0) {
    const Eigen::MatrixXd cross = H.block(frames, 0, integrated, frames);
    out -= cross.transpose() * H.block(frames, frames, integrated, integrated).ldlt().solve(cross);
  }
  return 0.5 * (out + out.transpose());
}

/// Directions of (x, y, yaw) of all frames of which nothing is known.
int unknown_directions(const Eigen::MatrixXd& information) {
  if (information.rows() == 0) return 0;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(information, Eigen::EigenvaluesOnly);
  const double largest = std::max(solver.eigenvalues().maxCoeff(), kTinyInformation);
  return static_cast<int>((solver.eigenvalues().array() < kNothing * largest).count());
}

/// Numbers that a piece of evidence tells.
int rank_of(const PoseEvidence& e) {
  const Eigen::SelfAdjointEigenSolver<Mat4> solver(e.information, Eigen::EigenvaluesOnly);
  return static_cast<int>((solver.eigenvalues().array() > kTinyInformation).count());
}

/// What the chosen alternatives cost besides their residuals, and what the fit is judged by.
void settle(const FrameProblem& p, double cost, Normal& normal, FrameSolution& s) {
  const Eigen::Index frames = p.frame_size();
  s.information = marginal(normal.H, frames, p.size() - frames);
  s.drift_information = marginal(normal.H, frames, p.bias_size());
  s.offset_information = marginal(normal.H, frames, 0);
  s.chi2 = cost;
  s.fit_chi2 = cost - normal.beyond_fit;
  s.prior_chi2 = 0.0;
  s.dof = static_cast<int>(p.ranges.size()) - 3 * (static_cast<int>(p.keys.size()) - 1) +
          unknown_directions(s.information);
  std::vector<int> priors(s.holds.size(), kNotAsked);
  for (std::size_t k = 0; k < p.evidence.size(); ++k) {
    const EvidenceGroup& group = p.evidence[k];
    const bool is_prior = group.alternatives.front().source == EvidenceSource::kPrior;
    double own = 0.0;
    if (s.holds[k] >= 0) {
      const auto at = static_cast<std::size_t>(s.holds[k]);
      const PoseEvidence& e = group.alternatives[at];
      const Vec4 r = Normal::evidence_residual(s.values, group, at);
      s.chi2 += e.chi2;
      s.dof += rank_of(e);
      own = e.chi2 + r.dot(e.information * r);
      if (is_prior) priors[k] = s.holds[k];
    } else if (s.holds[k] == kNoneHolds) {
      own = group.alternatives.front().wrong_chi2;
      s.chi2 += own;
    }
    if (is_prior) s.prior_chi2 += own;
  }
  normal.build_evidence(s.values, priors);
  s.prior_information = normal.H.topLeftCorner(frames, frames);
}

/// The alternative that costs least at some values.
struct Nearest {
  int alternative = kNoneHolds;
  double cost = std::numeric_limits<double>::infinity();
  Vec4 residual = Vec4::Zero();
};

Nearest nearest_of(const FrameValues& values, const EvidenceGroup& group) {
  Nearest out;
  for (std::size_t k = 0; k < group.alternatives.size(); ++k) {
    const PoseEvidence& e = group.alternatives[k];
    const Vec4 r = Normal::evidence_residual(values, group, k);
    const double cost = e.chi2 + r.dot(e.information * r);
    if (cost < out.cost) out = {static_cast<int>(k), cost, r};
  }
  return out;
}

bool finite(const FrameValues& v) {
  return std::all_of(v.T_ref_odom.begin(), v.T_ref_odom.end(), [](const YawPose& T) {
    return std::isfinite(T.yaw_rad) && T.t_m.allFinite();
  });
}

}  // namespace

FrameSolution solve_frames(const FrameProblem& problem, const FrameValues& start,
                           const std::vector<int>& holds) {
  FrameSolution s;
  s.values = start;
  s.holds = holds;
  const Eigen::Index others = problem.size() - problem.frame_size();
  if (s.values.others.size() != others) s.values.others.setZero(others);
  Normal here(problem);
  Normal there(problem);
  double cost = here.build(s.values, holds);
  double lambda = 1e-4;
  for (int k = 0; k < problem.settings.search.iterations && std::isfinite(cost); ++k) {
    Eigen::MatrixXd damped = here.H;
    damped.diagonal() *= 1.0 + lambda;
    damped.diagonal().array() += kTinyInformation;
    const Eigen::VectorXd step = -damped.ldlt().solve(here.g);
    const FrameValues tried = here.moved(s.values, step);
    const double cost_tried = there.build(tried, holds);
    if (cost_tried <= cost) {
      const bool done = cost - cost_tried <= kConverged * (1.0 + cost);
      s.values = tried;
      cost = cost_tried;
      std::swap(here.H, there.H);
      std::swap(here.g, there.g);
      std::swap(here.beyond_fit, there.beyond_fit);
      lambda = std::max(kLeastDamping, kEasier * lambda);
      if (done) break;
    } else {
      lambda *= kHarder;
      if (lambda > kMostDamping) break;
    }
  }
  s.valid = std::isfinite(cost) && finite(s.values) && here.H.allFinite();
  if (s.valid) settle(problem, cost, here, s);
  return s;
}

std::vector<int> best_alternatives(const FrameProblem& problem, const FrameValues& values,
                                   bool none_allowed) {
  std::vector<int> out;
  for (const EvidenceGroup& group : problem.evidence) {
    const Nearest nearest = nearest_of(values, group);
    const bool none = none_allowed && !(nearest.cost < group.alternatives.front().wrong_chi2);
    out.push_back(none ? kNoneHolds : nearest.alternative);
  }
  return out;
}

std::vector<int> near_alternatives(const FrameProblem& problem, const FrameValues& values) {
  const SearchSettings& one = problem.settings.search;
  std::vector<int> out;
  for (const EvidenceGroup& group : problem.evidence) {
    const Nearest nearest = nearest_of(values, group);
    const bool near = nearest.residual.tail<3>().norm() < one.merge_m &&
                      std::abs(nearest.residual[0]) < one.merge_deg * kDegree;
    const bool believable = nearest.cost < group.alternatives.front().wrong_chi2;
    out.push_back(near || believable ? nearest.alternative : kNoneHolds);
  }
  return out;
}

FrameSolution solve_frames_choosing(const FrameProblem& problem, const FrameSolution& start) {
  FrameSolution s = start;
  for (int round = 0; round < kChoices && s.valid; ++round) {
    const std::vector<int> holds = best_alternatives(problem, s.values, true);
    if (holds == s.holds) break;
    s = solve_frames(problem, s.values, holds);
  }
  return s;
}

}  // namespace rali::fleet
