#include "rali/fleet/frames/start_sift.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace rali::fleet {

using geometry::Vec3;

namespace {

/// Rigid solutions closer than this fraction of the merge distance of hypotheses are the same.
constexpr double kSameFraction = 0.2;

/// The problem with rigid paths: their errors widen ranges and evidence.
FrameProblem with_rigid_paths(const FrameProblem& problem) {
  FrameProblem rigid = problem;
  for (RangeTerm& r : rigid.ranges) {
    // The direction is not known yet: a third of the variance of all three axes.
    const double off_m2 = (r.x_drift.squaredNorm() + r.y_drift.squaredNorm()) / 3.0;
    r.sigma_m = std::sqrt(r.sigma_m * r.sigma_m + off_m2);
    r.x_drift.resize(3, 0);
    r.y_drift.resize(3, 0);
  }
  for (EvidenceGroup& group : rigid.evidence) {
    for (std::size_t k = 0; k < group.alternatives.size(); ++k) {
      group.alternatives[k].information = group.apart[k];
      group.a_drift[k].resize(4, 0);
      group.b_drift[k].resize(4, 0);
    }
  }
  std::fill(rigid.drifts.begin(), rigid.drifts.end(), Eigen::Index{0});
  return rigid;
}

/// A start after its rigid solution.
struct Sifted {
  FrameStart start;
  double yaw_rad = 0.0;  ///< of the frame that distinguishes starts
  Vec3 place_m;
  double chi2 = 0.0;
  std::size_t rank = 0;  ///< 0: no cheaper one is close; 1: none of the remaining ones; ...
};

bool near(const Sifted& s, const Sifted& o, const SearchSettings& search, double fraction) {
  return one_place((s.place_m - o.place_m).norm(), wrapped(s.yaw_rad - o.yaw_rad), search,
                   fraction);
}

/// @param all cheapest first; of equal ones the cheapest is kept, ranks are set
std::vector<Sifted> distinct(std::vector<Sifted> all, const SearchSettings& search) {
  std::vector<Sifted> kept;
  for (Sifted& s : all) {
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const Sifted& k) {
      return k.start.holds == s.start.holds && near(k, s, search, kSameFraction);
    });
    if (known) continue;
    std::vector<bool> taken(kept.size() + 1, false);
    for (const Sifted& k : kept) {
      if (near(k, s, search, 1.0)) taken[k.rank] = true;
    }
    s.rank = static_cast<std::size_t>(std::find(taken.begin(), taken.end(), false) - taken.begin());
    kept.push_back(std::move(s));
  }
  return kept;
}

}  // namespace

std::vector<FrameStart> sift_starts(const FrameProblem& problem, std::vector<FrameStart> starts,
                                    std::size_t frame) {
  const SearchSettings& search = problem.settings.search;
  const auto maximum = static_cast<std::size_t>(search.starts_max);
  if (starts.size() <= maximum) return starts;
  const FrameProblem rigid = with_rigid_paths(problem);
  const Eigen::Index others = problem.size() - problem.frame_size();
  std::vector<Sifted> all;
  for (FrameStart& start : starts) {
    start.values.others.setZero(rigid.bias_size());
    FrameSolution s = solve_frames_choosing(rigid, solve_frames(rigid, start.values, start.holds));
    if (!s.valid) continue;
    Sifted sifted;
    const YawPose& T = s.values.T_ref_odom[frame];
    sifted.yaw_rad = T.yaw_rad;
    sifted.place_m = T * problem.pivots_m[frame];
    sifted.chi2 = s.chi2;
    s.values.others.conservativeResizeLike(Eigen::VectorXd::Zero(others));
    sifted.start = {std::move(s.values), std::move(s.holds)};
    all.push_back(std::move(sifted));
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Sifted& s, const Sifted& o) { return s.chi2 < o.chi2; });
  all = distinct(std::move(all), search);
  std::stable_sort(all.begin(), all.end(),
                   [](const Sifted& s, const Sifted& o) { return s.rank < o.rank; });
  if (all.size() > maximum) all.resize(maximum);
  starts.clear();
  for (Sifted& s : all) starts.push_back(std::move(s.start));
  return starts;
}

}  // namespace rali::fleet
