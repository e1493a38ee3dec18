#include "rali/fleet/frames/frame_problem.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "rali/fleet/frames/drift_basis.hpp"
#include "rali/fleet/frames/information.hpp"
#include "rali/geometry/so3.hpp"

namespace rali::fleet {

using geometry::Vec3;

namespace {

std::optional<std::size_t> index_of(const std::vector<StreamKey>& keys, StreamKey key) {
  const auto at = std::find(keys.begin(), keys.end(), key);
  if (at == keys.end()) return std::nullopt;
  return static_cast<std::size_t>(at - keys.begin());
}

/// Measured points of the path of each frame.
using Paths = std::vector<std::vector<PathSample>>;

/// An antenna is nearer to its body.
constexpr double kLever_m = 1.0;

void add_track(const PairTrack& track, std::size_t a, std::size_t b, FrameProblem& problem,
               Paths& paths) {
  for (const RangeObservation& o : track.samples()) {
    RangeTerm r;
    r.a = a;
    r.b = b;
    r.pair = problem.pairs;
    r.t = o.t;
    r.x_m = o.x_a_m;
    r.y_m = o.y_b_m;
    r.range_m = o.range_m;
    r.sigma_m = o.sigma_m;
    problem.ranges.push_back(std::move(r));
    paths[a].push_back({o.t, o.x_a_m, o.x_covariance_m2});
    paths[b].push_back({o.t, o.y_b_m, o.y_covariance_m2});
  }
  ++problem.pairs;
}

/// Extends the path by compared bodies before its first and after its last range. Those between are
/// left out: from antenna to body and back is no travelled distance.
void add_bodies(const FrameProblem& problem, Paths& paths) {
  const Paths of_ranges = paths;
  const auto add = [&](std::size_t f, const PathSample& s) {
    const std::vector<PathSample>& known = of_ranges[f];
    const auto later = [](const PathSample& p, const PathSample& q) { return p.t < q.t; };
    const auto [first, last] = std::minmax_element(known.begin(), known.end(), later);
    if (first == known.end()) {
      paths[f].push_back(s);
      return;
    }
    const bool before = s.t < first->t, after = last->t < s.t;
    const PathSample& end = before ? *first : *last;
    if ((before || after) && (s.p_m - end.p_m).norm() > kLever_m) paths[f].push_back(s);
  };
  for (const EvidenceGroup& group : problem.evidence) {
    for (std::size_t k = 0; k < group.alternatives.size(); ++k) {
      const PoseEvidence& e = group.alternatives[k];
      if (!e.on_a || !e.on_b) continue;
      for (const PathSample& s : {e.on_a->start, e.on_a->body}) add(group.a[k], s);
      for (const PathSample& s : {e.on_b->start, e.on_b->body}) add(group.b[k], s);
    }
  }
}

/// Of the position. A block of a matrix without columns would be an offset to a null pointer.
Eigen::Matrix3Xd of_position(const Eigen::Matrix4Xd& drift) {
  if (drift.cols() == 0) return Eigen::Matrix3Xd(3, 0);
  return drift.bottomRows<3>();
}

/// Errors of the two bodies of an alternative, and its information if they are unknown.
void add_drift(const std::vector<DriftBasis>& bases, EvidenceGroup& group, std::size_t k) {
  const PoseEvidence& e = group.alternatives[k];
  const auto of = [&](const std::optional<ComparedBody>& on, std::size_t f) -> Eigen::Matrix4Xd {
    if (!e.on_a || !e.on_b) return Eigen::Matrix4Xd::Zero(4, 0);
    return bases[f].at(on->body.t, on->body.p_m);
  };
  group.a_drift.push_back(of(e.on_a, group.a[k]));
  group.b_drift.push_back(of(e.on_b, group.b[k]));
  Eigen::Matrix4Xd a = group.a_drift.back(), b = group.b_drift.back();
  const geometry::Mat3 R_b_a = geometry::rotation_from_rpy(0.0, 0.0, e.yaw_rad);
  if (a.cols() > 0) a.bottomRows<3>() = (R_b_a * a.bottomRows<3>()).eval();
  if (e.on_b && b.cols() > 0)
    b.bottomRows<3>() += quarter_turn(e.place_b_m - e.on_b->body.p_m) * b.row(0);
  const Mat4 unknown = a * a.transpose() + b * b.transpose();
  group.apart.push_back(with_error(e.information, unknown));
}

void add_drift(const Paths& paths, FrameProblem& problem) {
  std::vector<DriftBasis> bases;
  for (std::size_t f = 0; f < problem.keys.size(); ++f) {
    bases.emplace_back(paths[f], problem.settings.drift);
    problem.drifts[f] = bases.back().size();
    const auto first =
        std::min_element(paths[f].begin(), paths[f].end(),
                         [](const PathSample& p, const PathSample& q) { return p.t < q.t; });
    if (first != paths[f].end()) problem.pivots_m[f] = first->p_m;
  }
  for (RangeTerm& r : problem.ranges) {
    r.x_drift = of_position(bases[r.a].at(r.t, r.x_m));
    r.y_drift = of_position(bases[r.b].at(r.t, r.y_m));
  }
  for (EvidenceGroup& group : problem.evidence) {
    for (std::size_t k = 0; k < group.alternatives.size(); ++k) add_drift(bases, group, k);
  }
}

bool finite_path(const std::optional<ComparedBody>& on) {
  const auto finite = [](const PathSample& s) {
    return s.p_m.allFinite() && s.covariance_m2.allFinite();
  };
  return !on || (finite(on->start) && finite(on->body));
}

void add_evidence(const std::vector<PoseEvidence>& evidence, FrameProblem& problem) {
  std::map<int, std::size_t> groups;
  for (const PoseEvidence& given : evidence) {
    const auto a = index_of(problem.keys, given.a);
    const auto b = index_of(problem.keys, given.b);
    const bool finite = given.information.allFinite() && given.pivot_a_m.allFinite() &&
                        given.place_b_m.allFinite() && std::isfinite(given.yaw_rad) &&
                        finite_path(given.on_a) && finite_path(given.on_b);
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

/// Comparisons with rivals between two paths share walls and mistakes: where one misses the true
/// placement, the others do. How they are correlated is unknown, so together they weigh as one.
/// And one miss is not rare, so it must not decide alone: half of one.
void weigh_rivalled(FrameProblem& problem) {
  using Pair = std::pair<std::size_t, std::size_t>;
  const auto pair_of = [](const EvidenceGroup& g) -> Pair {
    return std::minmax(g.a.front(), g.b.front());
  };
  const auto rivalled = [](const EvidenceGroup& g) {
    const PoseEvidence& e = g.alternatives.front();
    return e.source != EvidenceSource::kPrior && e.group >= 0 && !e.unrivalled && !e.tested;
  };
  constexpr double kTogether = 0.5;
  std::map<Pair, double> count;
  for (const EvidenceGroup& group : problem.evidence) {
    if (rivalled(group)) count[pair_of(group)] += 1.0;
  }
  for (EvidenceGroup& group : problem.evidence) {
    if (!rivalled(group)) continue;
    const double weight = kTogether / count[pair_of(group)];
    for (PoseEvidence& e : group.alternatives) {
      e.information *= weight;
      e.chi2 *= weight;
      e.wrong_chi2 *= weight;
    }
  }
}

/// Marks the ranges between frames that a chain of start poses relates. Those of a pair share their
/// walls: in a storey all are too long by about as much, and by their number they would turn a
/// start pose by five sigma. So together they weigh as a few.
void bound_ranges(FrameProblem& problem) {
  std::vector<std::size_t> chain(problem.keys.size());
  std::iota(chain.begin(), chain.end(), std::size_t{0});
  for (const EvidenceGroup& group : problem.evidence) {
    if (group.alternatives.front().source != EvidenceSource::kPrior) continue;
    const std::size_t from = chain[group.a.front()], to = chain[group.b.front()];
    std::replace(chain.begin(), chain.end(), from, to);
  }
  constexpr double kIndependent = 20.0;
  std::vector<double> count(problem.pairs, 0.0);
  for (const RangeTerm& range : problem.ranges) count[range.pair] += 1.0;
  for (RangeTerm& range : problem.ranges) {
    range.bounded = chain[range.a] == chain[range.b];
    if (range.bounded) range.sigma_m *= std::sqrt(std::max(1.0, count[range.pair] / kIndependent));
  }
}

}  // namespace

Eigen::Index FrameProblem::size() const {
  return frame_size() + bias_size() +
         std::accumulate(drifts.begin(), drifts.end(), Eigen::Index{0});
}

Eigen::Index FrameProblem::drift_at(std::size_t frame) const {
  const auto end = drifts.begin() + static_cast<std::ptrdiff_t>(frame);
  return bias_size() + std::accumulate(drifts.begin(), end, Eigen::Index{0});
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
  Paths paths(keys.size());
  for (const PairTrack& track : tracks) {
    const auto a = index_of(keys, track.a());
    const auto b = index_of(keys, track.b());
    if (a && b && *a != *b) add_track(track, *a, *b, problem, paths);
  }
  add_evidence(evidence, problem);
  if (settings.commit.rule == CommitRule::kCertain) weigh_rivalled(problem);
  add_bodies(problem, paths);
  add_drift(paths, problem);
  if (settings.commit.rule != CommitRule::kAtSize) bound_ranges(problem);
  return problem;
}

}  // namespace rali::fleet
