#include "rali/fleet/frames/frame_problem.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "rali/fleet/frames/drift_basis.hpp"

namespace rali::fleet {

using geometry::Vec3;

namespace {

std::optional<std::size_t> index_of(const std::vector<StreamKey>& keys, StreamKey key) {
  const auto at = std::find(keys.begin(), keys.end(), key);
  if (at == keys.end()) return std::nullopt;
  return static_cast<std::size_t>(at - keys.begin());
}

/// The term, and the end of it, that a sample of a path belongs to.
struct End {
  std::size_t term = 0;
  bool is_a = true;
};

struct Paths {
  std::vector<std::vector<PathSample>> samples;  ///< per frame
  std::vector<std::vector<End>> ends;
};

void add_track(const PairTrack& track, std::size_t a, std::size_t b, FrameProblem& problem,
               Paths& paths) {
  for (const RangeObservation& o : track.samples()) {
    const std::size_t term = problem.ranges.size();
    RangeTerm r;
    r.a = a;
    r.b = b;
    r.pair = problem.pairs;
    r.x_m = o.x_a_m;
    r.y_m = o.y_b_m;
    r.range_m = o.range_m;
    r.sigma_m = o.sigma_m;
    problem.ranges.push_back(std::move(r));
    paths.samples[a].push_back({o.t, o.x_a_m, o.x_covariance_m2});
    paths.ends[a].push_back({term, true});
    paths.samples[b].push_back({o.t, o.y_b_m, o.y_covariance_m2});
    paths.ends[b].push_back({term, false});
  }
  ++problem.pairs;
}

void add_drift(const Paths& paths, FrameProblem& problem) {
  for (std::size_t f = 0; f < problem.keys.size(); ++f) {
    const auto basis = drift_basis(paths.samples[f], problem.settings.drift);
    problem.drifts[f] = basis.empty() ? 0 : basis.front().cols();
    for (std::size_t i = 0; i < basis.size(); ++i) {
      const End& end = paths.ends[f][i];
      RangeTerm& term = problem.ranges[end.term];
      (end.is_a ? term.x_drift : term.y_drift) = basis[i];
    }
    const auto first =
        std::min_element(paths.samples[f].begin(), paths.samples[f].end(),
                         [](const PathSample& p, const PathSample& q) { return p.t < q.t; });
    if (first != paths.samples[f].end()) problem.pivots_m[f] = first->p_m;
  }
}

void add_evidence(const std::vector<PoseEvidence>& evidence, FrameProblem& problem) {
  std::map<int, std::size_t> groups;
  for (const PoseEvidence& given : evidence) {
    const auto a = index_of(problem.keys, given.a);
    const auto b = index_of(problem.keys, given.b);
    const bool finite = given.information.allFinite() && given.pivot_a_m.allFinite() &&
                        given.place_b_m.allFinite() && std::isfinite(given.yaw_rad);
    if (!a || !b || *a == *b || !finite) continue;
    PoseEvidence e = given;
    const ScanToMapSettings& scan = problem.settings.scan2map;
    if (e.source != EvidenceSource::kPrior && scan.weight == ScanWeight::kFixed &&
        e.point_sigma_m > 0.0) {
      e.information *= e.point_sigma_m * e.point_sigma_m / (scan.sigma_m * scan.sigma_m);
    }
    std::size_t at = problem.evidence.size();
    if (e.group >= 0) at = groups.emplace(e.group, at).first->second;
    if (at == problem.evidence.size()) problem.evidence.emplace_back();
    EvidenceGroup& group = problem.evidence[at];
    group.alternatives.push_back(std::move(e));
    group.a.push_back(*a);
    group.b.push_back(*b);
  }
  for (EvidenceGroup& group : problem.evidence) {
    double minimum = group.alternatives.front().chi2;
    for (const PoseEvidence& e : group.alternatives) minimum = std::min(minimum, e.chi2);
    for (PoseEvidence& e : group.alternatives) e.chi2 -= minimum;
  }
}

/// Marks the ranges between frames that a chain of start poses relates.
void bound_ranges(FrameProblem& problem) {
  std::vector<std::size_t> chain(problem.keys.size());
  std::iota(chain.begin(), chain.end(), std::size_t{0});
  for (const EvidenceGroup& group : problem.evidence) {
    if (group.alternatives.front().source != EvidenceSource::kPrior) continue;
    const std::size_t from = chain[group.a.front()], to = chain[group.b.front()];
    std::replace(chain.begin(), chain.end(), from, to);
  }
  for (RangeTerm& range : problem.ranges) range.bounded = chain[range.a] == chain[range.b];
}

}  // namespace

Eigen::Index FrameProblem::size() const {
  return frame_size() + bias_size() +
         std::accumulate(drifts.begin(), drifts.end(), Eigen::Index{0});
}

FrameProblem make_frame_problem(const std::vector<StreamKey>& keys,
                                const std::vector<PairTrack>& tracks,
                                const std::vector<PoseEvidence>& evidence,
                                const InitSettings& settings) {
  FrameProblem problem;
  problem.keys = keys;
  problem.settings = settings;
  problem.pivots_m.assign(keys.size(), Vec3::Zero());
  problem.drifts.assign(keys.size(), 0);
  Paths paths;
  paths.samples.resize(keys.size());
  paths.ends.resize(keys.size());
  for (const PairTrack& track : tracks) {
    const auto a = index_of(keys, track.a());
    const auto b = index_of(keys, track.b());
    if (a && b && *a != *b) add_track(track, *a, *b, problem, paths);
  }
  add_drift(paths, problem);
  add_evidence(evidence, problem);
  if (settings.commit.rule != CommitRule::kAtSize) bound_ranges(problem);
  return problem;
}

}  // namespace rali::fleet
