#include <algorithm>

#include <Eigen/Cholesky>

#include "rali/fleet/centre/group_estimate.hpp"
#include "rali/fleet/centre/round_centre.hpp"
#include "rali/fleet/centre/scan_evidence.hpp"
#include "rali/graph/loops.hpp"
#include "rali/graph/root.hpp"

namespace rali::fleet {

using geometry::Mat6;
using geometry::SE3;

const KeyframePose* RoundCentre::pose_of(KeyframeId id, const FleetEstimate& live) const {
  for (const auto* keyframes : {&live.keyframes, &done_.keyframes}) {
    const auto found = keyframes->find(id);
    if (found != keyframes->end()) return &found->second;
  }
  return nullptr;
}

/// Compares the pieces of this round with those of earlier ones. @return by path the first node to
/// solve for: the start of the round, unless a loop closes. Any loop into one of the last rounds
/// counts, because solving these again is cheap
/// @param lately start of the last rounds, by path; empty if there are none
std::vector<std::size_t> RoundCentre::look_back(const Solution& solution,
                                                std::span<const std::size_t> lately,
                                                Executor& executor) {
  const FleetSettings& s = centre_.settings();
  std::vector<std::size_t> nodes = begins();
  if (!s.loops.use || solution.live_from == 0 || stop_.raised()) return nodes;
  const auto guess = [&](std::size_t target, std::size_t source) -> std::optional<places::Guess> {
    if (target >= solution.live_from || source < solution.live_from) return std::nullopt;
    const PathSubmap& t = solution.pieces[target];
    const PathSubmap& p = solution.pieces[source];
    const auto b = between(t.submap.middle(), p.submap.middle(), solution.estimate);
    if (!b) return std::nullopt;
    return fleet::guess_of(t, p, b->T_map_from, b->T_map_to, b->covariance);
  };
  std::vector<LoopCandidate> candidates =
      near_candidates(solution.pieces, guess, s.places.near, s.loops);
  std::erase_if(candidates, [&](const LoopCandidate& c) {
    return !memory_.compared
                .emplace(solution.pieces[c.target].submap.middle(),
                         solution.pieces[c.source].submap.middle())
                .second;
  });
  for (const LoopFound& found :
       compare_all(solution.pieces, std::move(candidates), s.places.recognise, executor, stop_)) {
    if (!found.recognition.usable()) continue;
    const Loop loop = loop_of(solution.pieces, found, s.loops.bend_per_m);
    memory_.loops[{loop.from, loop.to}] = loop;
    const PathSubmap& before = solution.pieces[found.candidate.target];
    const auto b = between(loop.from, loop.to, solution.estimate);
    const bool near = !lately.empty() && before.node >= lately[before.path];
    if (!b || !worth_it(loop, *b, near)) continue;
    nodes[before.path] = std::min(nodes[before.path], before.node);
  }
  return nodes;
}

std::optional<RoundCentre::Between> RoundCentre::between(KeyframeId from, KeyframeId to,
                                                         const FleetEstimate& live) const {
  const KeyframePose* before = pose_of(from, live);
  const KeyframePose* now = pose_of(to, live);
  if (before == nullptr || now == nullptr) return std::nullopt;
  // Their correlation is not stored; it would only reduce the uncertainty.
  Eigen::Matrix<double, 12, 12> joint = Eigen::Matrix<double, 12, 12>::Zero();
  joint.topLeftCorner<6, 6>() = before->covariance;
  joint.bottomRightCorner<6, 6>() = now->covariance;
  return Between{before->T_map_body, now->T_map_body,
                 relative_covariance(before->T_map_body, now->T_map_body, joint)};
}

/// Whether earlier rounds must be solved again for a loop. @param near loop into one of the last:
/// then also for one that agrees with the current poses within its own errors
bool RoundCentre::worth_it(const Loop& loop, const Between& between, bool near) const {
  if (centre_.settings().separator.reopen == ReopenBy::kAny) return true;
  const SE3 T = between.T_map_from.inverse() * between.T_map_to;
  geometry::Vec6 error;  // rotation in `to`, position in `from`
  error << geometry::so3_log(loop.T_from_to.R.transpose() * T.R), T.p - loop.T_from_to.p;
  const bool news = error.dot(loop.information * error) > graph::loop_chi2_gate(6);
  return (near || news) && may_hold(loop, error, between.covariance);
}

/// False for a loop that would certainly be rejected after solving everything again: beyond the
/// total uncertainty of both poses, or shifted along a passage.
bool RoundCentre::may_hold(const Loop& loop, const geometry::Vec6& error,
                           const Mat6& covariance) const {
  const FleetSettings& s = centre_.settings();
  if (slide_m(loop.information, error.tail<3>()) > s.loops.slide_max_m) return false;
  if (!s.loops.veto) return true;
  // In units of the loop's own sigmas; directions without information are zero and add nothing.
  const Mat6 root = graph::information_root(loop.information);
  const geometry::Vec6 e = root * error;
  const Mat6 S = root * covariance * root.transpose() + Mat6::Identity();
  return e.dot(S.ldlt().solve(e)) <= s.joint.graph.veto_exact_to;
}

}  // namespace rali::fleet
