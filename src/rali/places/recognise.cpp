#include "rali/places/recognise.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rali::places {

using geometry::SE3;
using geometry::Vec3;

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

double turned(const SE3& a, const SE3& b) { return std::abs(wrapped(yaw_of(a.R) - yaw_of(b.R))); }

bool same(const SE3& a, const SE3& b, const RecogniseSettings& s) {
  return (a.p - b.p).norm() < s.apart_m && turned(a, b) < s.apart_deg * kDegree;
}

int agreeing(const Placement& p) {
  return std::min(p.verdict.source_in_target.agree, p.verdict.target_in_source.agree);
}

/// Contradictions weigh more than agreement is worth: a wrong place agrees too, on its walls.
double merit(const Placement& p) {
  constexpr double kContradiction = 5.0;
  const Agreement& a = p.verdict.source_in_target;
  const Agreement& b = p.verdict.target_in_source;
  return a.agree + b.agree - kContradiction * (a.conflict + b.conflict);
}

/// What is added to the placements is believable and new, or better than the one it is like.
void keep(Placement&& placement, const RecogniseSettings& s, std::vector<Placement>& kept) {
  for (Placement& old : kept) {
    if (!same(old.registration.T_target_source, placement.registration.T_target_source, s)) {
      continue;
    }
    if (merit(placement) > merit(old)) old = std::move(placement);
    return;
  }
  kept.push_back(std::move(placement));
}

bool rivals(const Placement& best, const Placement& other, const RecogniseSettings& s) {
  return other.verdict.conflict_share() < best.verdict.conflict_share() + s.rival_conflict &&
         agreeing(other) > s.rival_overlap * agreeing(best);
}

/// The line through the best placement that all rivals are on, if there is one.
std::optional<Vec3> common_axis(const Placement& best, std::span<const SE3> rivals,
                                const RecogniseSettings& s) {
  const SE3& T = best.registration.T_target_source;
  Vec3 farthest = Vec3::Zero();
  for (const SE3& rival : rivals) {
    const Vec3 d = rival.p - T.p;
    if (d.norm() > farthest.norm()) farthest = d;
  }
  if (farthest.norm() < 1e-6) return {};
  const Vec3 axis = farthest.normalized();
  for (const SE3& rival : rivals) {
    const Vec3 d = rival.p - T.p;
    if ((d - axis * axis.dot(d)).norm() > s.along_m) return {};
    if (turned(rival, T) > s.apart_deg * kDegree) return {};
  }
  return axis;
}

/// Compares the best placement with the others and takes from it what it must not claim.
void judge(const RecogniseSettings& s, Recognition& out) {
  if (out.placements.empty()) return;
  Placement& best = out.placements.front();
  std::vector<SE3> others;
  for (std::size_t k = 1; k < out.placements.size(); ++k) {
    if (rivals(best, out.placements[k], s)) {
      others.push_back(out.placements[k].registration.T_target_source);
    }
  }
  out.certainty = Certainty::kUnique;
  if (others.empty()) return;
  const auto axis = common_axis(best, others, s);
  out.certainty = axis ? Certainty::kAlongAxis : Certainty::kAmbiguous;
  if (!axis) return;
  out.axis_target = *axis;
  forget_direction(best.registration, *axis);
}

}  // namespace

Recognition recognise_from(const Submap& target, const Submap& source, std::span<const SE3> starts,
                           const RecogniseSettings& s, const std::optional<Guess>& guess) {
  Recognition out;
  for (const SE3& start : starts) {
    Placement p;
    p.registration = align(target, source, start, s.align);
    ++out.tried;
    if (!p.registration.converged) continue;
    if (guess && !within(*guess, p.registration.T_target_source, s.search.gate)) continue;
    p.verdict = verify(target, source, p.registration, s.verify);
    if (p.verdict.believable()) keep(std::move(p), s, out.placements);
  }
  std::stable_sort(out.placements.begin(), out.placements.end(),
                   [](const Placement& a, const Placement& b) { return merit(a) > merit(b); });
  judge(s, out);
  return out;
}

Recognition recognise(const Submap& target, const Submap& source, const RecogniseSettings& s,
                      const std::optional<Guess>& guess) {
  std::vector<SE3> starts;
  if (guess) starts.push_back(guess->T_target_source);
  const bool tight = guess && horizontal_sigma_m(*guess) < s.tight_m &&
                     yaw_sigma_rad(*guess) < s.tight_deg * kDegree;
  if (!tight) {
    for (const Hypothesis& h : global_hypotheses(target, source, s.search, guess).places) {
      starts.push_back(h.T_a_b);
    }
  }
  return recognise_from(target, source, starts, s, guess);
}

bool may_overlap(const Guess& guess, const NearSettings& s) {
  const double sigma_m = horizontal_sigma_m(guess);
  if (!(sigma_m <= s.sigma_max_m)) return false;
  return guess.T_target_source.p.head<2>().norm() - s.gate * sigma_m <= s.view_m;
}

}  // namespace rali::places
