#include <algorithm>

#include "rali/fleet/centre/group_estimate.hpp"
#include "rali/fleet/centre/round_centre.hpp"
#include "rali/fleet/centre/scan_evidence.hpp"
#include "rali/graph/loops.hpp"

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

/// Compares the pieces of this round with those of earlier ones. @return by path the first node
/// that it is worth to solve for, which is where the round begins unless a loop closes: into one of
/// the last rounds any, since solving these again is cheap
std::vector<std::size_t> RoundCentre::look_back(const Solution& solution, Executor& executor) {
  const FleetSettings& s = centre_.settings();
  std::vector<std::size_t> nodes = begins();
  if (!s.loops.use || solution.live_from == 0) return nodes;
  const auto guess = [&](std::size_t target, std::size_t source) -> std::optional<places::Guess> {
    if (target >= solution.live_from || source < solution.live_from) return std::nullopt;
    const PathSubmap& t = solution.pieces[target];
    const PathSubmap& p = solution.pieces[source];
    const KeyframePose* before = pose_of(t.submap.middle(), solution.estimate);
    const KeyframePose* now = pose_of(p.submap.middle(), solution.estimate);
    if (before == nullptr || now == nullptr) return std::nullopt;
    // What both have in common is not known any more: it would only make the doubt smaller.
    Eigen::Matrix<double, 12, 12> joint = Eigen::Matrix<double, 12, 12>::Zero();
    joint.topLeftCorner<6, 6>() = before->covariance;
    joint.bottomRightCorner<6, 6>() = now->covariance;
    const Mat6 P = relative_covariance(before->T_map_body, now->T_map_body, joint);
    return fleet::guess_of(t, p, before->T_map_body, now->T_map_body, P);
  };
  std::vector<LoopCandidate> candidates =
      near_candidates(solution.pieces, guess, s.places.near, s.loops);
  std::erase_if(candidates, [&](const LoopCandidate& c) {
    return !memory_.compared
                .emplace(solution.pieces[c.target].submap.middle(),
                         solution.pieces[c.source].submap.middle())
                .second;
  });
  const std::vector<std::size_t> lately =
      history_.begins(paths(), static_cast<std::size_t>(s.boundary.near_rounds));
  for (const LoopFound& found :
       compare_all(solution.pieces, std::move(candidates), s.places.recognise, executor)) {
    if (!found.recognition.usable()) continue;
    const Loop loop = loop_of(solution.pieces, found);
    memory_.loops[{loop.from, loop.to}] = loop;
    const PathSubmap& before = solution.pieces[found.candidate.target];
    const bool near = !lately.empty() && before.node >= lately[before.path];
    if (!near && !says_news(loop, solution.estimate)) continue;
    nodes[before.path] = std::min(nodes[before.path], before.node);
  }
  return nodes;
}

/// A loop that the poses fit as they are, within its own errors, would leave them there.
bool RoundCentre::says_news(const Loop& loop, const FleetEstimate& estimate) const {
  if (centre_.settings().boundary.reopen == ReopenBy::kAny) return true;
  const KeyframePose* from = pose_of(loop.from, estimate);
  const KeyframePose* to = pose_of(loop.to, estimate);
  if (from == nullptr || to == nullptr) return false;
  const SE3 T = from->T_map_body.inverse() * to->T_map_body;
  geometry::Vec6 error;
  error << geometry::so3_log(loop.T_from_to.R.transpose() * T.R), T.p - loop.T_from_to.p;
  const double chi2 = error.dot(loop.information * error);
  return chi2 > graph::loop_chi2_gate(6);
}

}  // namespace rali::fleet
