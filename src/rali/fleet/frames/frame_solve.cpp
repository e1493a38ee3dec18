#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "rali/fleet/frames/frame_normal.hpp"

namespace rali::fleet {

namespace {

/// Keeps unobservable directions at their initial values.
constexpr double kTinyInformation = 1e-6;
/// An eigenvalue below this fraction of the largest counts as zero: unobservable.
constexpr double kNothing = 1e-9;
constexpr double kConverged = 1e-9;
constexpr double kEasier = 0.1, kHarder = 10.0, kMinDamping = 1e-9, kMaxDamping = 1e8;
/// Iterations of the choice of alternatives, because two choices could alternate.
constexpr int kChoices = 4;

/// The frames' part of H with the first `integrated` of the other unknowns marginalised and the
/// rest fixed.
Eigen::MatrixXd marginal(const Eigen::MatrixXd& H, Eigen::Index frames, Eigen::Index integrated) {
  Eigen::MatrixXd out = H.topLeftCorner(frames, frames);
  if (integrated > 0) {
    const Eigen::MatrixXd cross = H.block(frames, 0, integrated, frames);
    out -= cross.transpose() * H.block(frames, frames, integrated, integrated).ldlt().solve(cross);
  }
  return 0.5 * (out + out.transpose());
}

/// Number of unobservable directions of (x, y, yaw) of all frames.
int unknown_directions(const Eigen::MatrixXd& information) {
  if (information.rows() == 0) return 0;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(information, Eigen::EigenvaluesOnly);
  const double largest = std::max(solver.eigenvalues().maxCoeff(), kTinyInformation);
  return static_cast<int>((solver.eigenvalues().array() < kNothing * largest).count());
}

/// Rank of the information of a piece of evidence.
int rank_of(const PoseEvidence& e) {
  const Eigen::SelfAdjointEigenSolver<Mat4> solver(e.information, Eigen::EigenvaluesOnly);
  return static_cast<int>((solver.eigenvalues().array() > kTinyInformation).count());
}

/// Sets the informations and costs of a solution, and the chi2 and dof of its fit.
void settle(const FrameProblem& p, double cost, FrameNormal& normal, FrameSolution& s) {
  const Eigen::Index frames = p.frame_size();
  s.information = marginal(normal.H, frames, p.size() - frames);
  s.drift_information = marginal(normal.H, frames, p.bias_size());
  s.offset_information = marginal(normal.H, frames, 0);
  s.chi2 = cost;
  s.fit_chi2 = cost - normal.beyond_fit;
  s.obstructed_chi2 = normal.obstructed;
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
      const Vec4 r = evidence_residual(p, s.values, group, at);
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

/// The alternative with the least cost at given values.
struct Nearest {
  int alternative = kNoneHolds;
  double cost = std::numeric_limits<double>::infinity();
  Vec4 residual = Vec4::Zero();
};

/// Cost of an alternative: as it is, if the values are adapted to it; else if they could be.
double cost_of(const EvidenceGroup& group, std::size_t k, bool is_held, const Vec4& r) {
  const Mat4& information = is_held ? group.alternatives[k].information : group.apart[k];
  return group.alternatives[k].chi2 + r.dot(information * r);
}

/// @param held to which the values are adapted, or kNoneHolds
/// @param refused alternatives that are not considered
Nearest nearest_of(const FrameProblem& problem, const FrameValues& values,
                   const EvidenceGroup& group, int held, const std::set<int>& refused = {}) {
  Nearest out;
  for (std::size_t k = 0; k < group.alternatives.size(); ++k) {
    const int alternative = static_cast<int>(k);
    if (refused.count(alternative) > 0) continue;
    const Vec4 r = evidence_residual(problem, values, group, k);
    const double cost = cost_of(group, k, alternative == held, r);
    if (cost < out.cost) out = {alternative, cost, r};
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
  FrameNormal here(problem);
  FrameNormal there(problem);
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
      here.swap(there);
      lambda = std::max(kMinDamping, kEasier * lambda);
      if (done) break;
    } else {
      lambda *= kHarder;
      if (lambda > kMaxDamping) break;
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
    const Nearest nearest = nearest_of(problem, values, group, kNoneHolds);
    const bool none = none_allowed && !(nearest.cost < group.alternatives.front().wrong_chi2);
    out.push_back(none ? kNoneHolds : nearest.alternative);
  }
  return out;
}

std::vector<int> near_alternatives(const FrameProblem& problem, const FrameValues& values) {
  std::vector<int> out;
  for (const EvidenceGroup& group : problem.evidence) {
    const Nearest nearest = nearest_of(problem, values, group, kNoneHolds);
    const bool near =
        one_place(nearest.residual.tail<3>().norm(), nearest.residual[0], problem.settings.search);
    const bool believable = nearest.cost < group.alternatives.front().wrong_chi2;
    out.push_back(near || believable ? nearest.alternative : kNoneHolds);
  }
  return out;
}

FrameSolution solve_frames_choosing(const FrameProblem& problem, const FrameSolution& start,
                                    const std::set<std::size_t>& kept) {
  FrameSolution s = start;
  // One that stays wrong in a solution adapted to it is not tried again: the choice ends.
  std::vector<std::set<int>> refused(problem.evidence.size());
  for (int round = 0; round < kChoices && s.valid; ++round) {
    std::vector<int> holds = s.holds;
    for (std::size_t g = 0; g < holds.size(); ++g) {
      if (kept.contains(g)) continue;
      const EvidenceGroup& group = problem.evidence[g];
      const Nearest nearest = nearest_of(problem, s.values, group, s.holds[g], refused[g]);
      const bool none = !(nearest.cost < group.alternatives.front().wrong_chi2);
      holds[g] = none ? kNoneHolds : nearest.alternative;
      if (s.holds[g] >= 0 && holds[g] != s.holds[g]) refused[g].insert(s.holds[g]);
    }
    if (holds == s.holds) break;
    s = solve_frames(problem, s.values, holds);
  }
  return s;
}

}  // namespace rali::fleet
