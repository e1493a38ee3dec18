#include "rali/fleet/frames/hypotheses.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "rali/fleet/frames/start_sift.hpp"

namespace rali::fleet {

using geometry::Vec2;
using geometry::Vec3;

namespace {

/// Number of evidence headings combined with positions from ranges that leave the heading open.
constexpr std::size_t kHeadings = 8;
/// A range that is almost vertical has no direction in the plane.
constexpr double kMinFlat_m = 0.05;
/// Few enough that the error of a path grows little from one stage to the next.
constexpr std::size_t kRangesPerStage = 16;
/// Minima closer than this are the same one, reached from two sides.
constexpr double kSameMinimum_m = 0.02;

std::optional<std::size_t> index_in(const FrameGroup& g, StreamKey key) {
  const auto at = std::find(g.keys.begin(), g.keys.end(), key);
  if (at == g.keys.end()) return std::nullopt;
  return static_cast<std::size_t>(at - g.keys.begin());
}

double extent_m(const std::vector<PlanarRange>& ranges, bool of_x) {
  double extent = 0.0;
  for (const PlanarRange& r : ranges) {
    const Vec2 d = of_x ? Vec2(r.x_m - ranges.front().x_m) : Vec2(r.y_m - ranges.front().y_m);
    extent = std::max(extent, d.norm());
  }
  return extent;
}

/// Ranges between the groups, in the frames of their references.
std::vector<PlanarRange> cross_ranges(const FrameGroup& a, const FrameGroup& b,
                                      const std::vector<PairTrack>& tracks) {
  std::vector<PlanarRange> out;
  for (const PairTrack& track : tracks) {
    const bool swap = index_in(a, track.b()).has_value();
    const auto in_a = index_in(a, swap ? track.b() : track.a());
    const auto in_b = index_in(b, swap ? track.a() : track.b());
    if (!in_a || !in_b) continue;
    for (const RangeObservation& o : track.samples()) {
      const Vec3 x = a.T_ref_odom[*in_a] * (swap ? o.y_b_m : o.x_a_m);
      const Vec3 y = b.T_ref_odom[*in_b] * (swap ? o.x_a_m : o.y_b_m);
      const double up_m = x.z() - y.z();
      const double flat2 = o.range_m * o.range_m - up_m * up_m;
      PlanarRange r;
      r.x_m = x.head<2>();
      r.y_m = y.head<2>();
      r.range_m = std::sqrt(std::max(flat2, kMinFlat_m * kMinFlat_m));
      r.sigma_m = o.sigma_m;
      out.push_back(r);
    }
  }
  return out;
}

class Finder {
 public:
  Finder(const FrameGroup& a, const FrameGroup& b, const std::vector<PairTrack>& tracks,
         const std::vector<PoseEvidence>& evidence, const InitSettings& settings)
      : a_(a), b_(b), settings_(settings) {
    std::vector<StreamKey> keys = b.keys;
    keys.insert(keys.end(), a.keys.begin(), a.keys.end());
    problem_ = make_frame_problem(keys, tracks, evidence, settings);
    out_.ranges = cross_ranges(a, b, tracks);
    out_.a_stands = extent_m(out_.ranges, true) < settings.search.stand_m;
    out_.b_stands = extent_m(out_.ranges, false) < settings.search.stand_m;
    for (const EvidenceGroup& g : problem_.evidence) {
      if (g.alternatives.front().source == EvidenceSource::kPrior) out_.has_prior = true;
    }
    out_.only_scans = !out_.has_prior && out_.ranges.empty();
  }

  HypothesisSet find() {
    const bool only_prior = settings_.commit.rule == CommitRule::kAtSize;
    if (!only_prior) add_range_starts();
    for (std::size_t g = 0; g < problem_.evidence.size(); ++g) {
      const EvidenceGroup& group = problem_.evidence[g];
      const bool is_prior = group.alternatives.front().source == EvidenceSource::kPrior;
      if (only_prior && !is_prior) continue;
      for (std::size_t k = 0; k < group.alternatives.size(); ++k) {
        const auto T = from_evidence(g, k);
        if (!T) continue;
        add_start(*T, g, static_cast<int>(k));
        if (is_prior && !only_prior) follow_in_time(*T, g, static_cast<int>(k));
      }
    }
    for (const FrameStart& start : sift_starts(problem_, std::move(starts_), b_.keys.size())) {
      refine(start);
    }
    std::stable_sort(
        out_.all.begin(), out_.all.end(),
        [](const FrameHypothesis& h, const FrameHypothesis& k) { return h.chi2 < k.chi2; });
    merge();
    const auto maximum = static_cast<std::size_t>(settings_.search.hypotheses_max);
    if (out_.all.size() > maximum) out_.all.resize(maximum);
    return std::move(out_);
  }

 private:
  void add_range_starts() {
    const bool degenerate = out_.a_stands || out_.b_stands;
    for (const PlanarSolution& s : search_plane(out_.ranges, degenerate, settings_)) {
      const YawPose T{s.yaw_rad, Vec3(s.t_m.x(), s.t_m.y(), 0.0)};
      add_start(T, kNoGroup, kNoneHolds);
      if (problem_.evidence.empty()) continue;
      add_start(T, kNoGroup, 0);
      if (!degenerate) continue;
      for (const double yaw_rad : evidence_headings())
        add_start(turned_to(T, yaw_rad), kNoGroup, 0);
    }
  }

  /// The same position as constrained by ranges to or from a vehicle at standstill, at another
  /// heading.
  [[nodiscard]] YawPose turned_to(const YawPose& T, double yaw_rad) const {
    const auto lift = [](const Vec2& v) { return Vec3(v.x(), v.y(), 0.0); };
    YawPose out{yaw_rad, Vec3::Zero()};
    if (out_.a_stands) {
      const Vec3 x = lift(out_.ranges.front().x_m);
      out.t_m = T * x - out.turned(x);
    } else {
      const Vec3 y = lift(out_.ranges.front().y_m);
      out.t_m = y - out.turned(T.inverse() * y);
    }
    return out;
  }

  [[nodiscard]] std::vector<double> evidence_headings() const {
    std::vector<double> out;
    for (std::size_t g = 0; g < problem_.evidence.size(); ++g) {
      for (std::size_t k = 0; k < problem_.evidence[g].alternatives.size(); ++k) {
        const auto T = from_evidence(g, k);
        if (!T || out.size() >= kHeadings) continue;
        const bool known = std::any_of(out.begin(), out.end(), [&](double yaw_rad) {
          return std::abs(wrapped(yaw_rad - T->yaw_rad)) < settings_.search.merge_deg * kDegree;
        });
        if (!known) out.push_back(T->yaw_rad);
      }
    }
    return out;
  }

  /// T_b_a of the references by this alternative; nothing if it is within one group.
  [[nodiscard]] std::optional<YawPose> from_evidence(std::size_t g, std::size_t k) const {
    const PoseEvidence& e = problem_.evidence[g].alternatives[k];
    if (const auto a = index_in(a_, e.a), b = index_in(b_, e.b); a && b) {
      return b_.T_ref_odom[*b] * e.T_b_a() * a_.T_ref_odom[*a].inverse();
    }
    if (const auto a = index_in(a_, e.b), b = index_in(b_, e.a); a && b) {
      return b_.T_ref_odom[*b] * e.T_b_a().inverse() * a_.T_ref_odom[*a].inverse();
    }
    return std::nullopt;
  }

  [[nodiscard]] FrameValues values_at(const YawPose& T_b_a) const {
    FrameValues values;
    values.T_ref_odom = b_.T_ref_odom;
    for (const YawPose& T : a_.T_ref_odom) values.T_ref_odom.push_back(T_b_a * T);
    values.others.setZero(problem_.size() - problem_.frame_size());
    return values;
  }

  /// @param group fixed to its alternative `k`; others use the nearest, and none if k is none
  void add_start(const YawPose& T_b_a, std::size_t group, int k) {
    FrameValues values = values_at(T_b_a);
    std::vector<int> holds(problem_.evidence.size(), kNoneHolds);
    if (group != kNoGroup) {
      holds = near_alternatives(problem_, values);
      holds[group] = k;
    } else if (k != kNoneHolds) {
      holds = best_alternatives(problem_, values, false);
    }
    starts_.push_back({std::move(values), std::move(holds)});
  }

  /// From a start pose on, with more and more of the ranges in order of time. In a column through a
  /// tunnel the paths drift apart by more than the distance between the vehicles: with all ranges
  /// at once the solution would have the vehicles pass each other.
  void follow_in_time(const YawPose& T_b_a, std::size_t group, int k) {
    std::vector<Time> times;
    for (const RangeTerm& r : problem_.ranges) times.push_back(r.t);
    std::sort(times.begin(), times.end());
    std::vector<int> holds(problem_.evidence.size(), kNotAsked);
    holds[group] = k;
    FrameStart start{values_at(T_b_a), {}};
    FrameProblem part = problem_;
    for (std::size_t n = kRangesPerStage; n < times.size(); n += kRangesPerStage) {
      part.ranges.clear();
      std::copy_if(problem_.ranges.begin(), problem_.ranges.end(), std::back_inserter(part.ranges),
                   [&](const RangeTerm& r) { return r.t < times[n]; });
      const FrameSolution s = solve_frames(part, start.values, holds);
      if (s.valid) start.values = s.values;
    }
    start.holds = near_alternatives(problem_, start.values);
    start.holds[group] = k;
    refine(start);
  }

  void refine(const FrameStart& start) {
    FrameSolution s = solve_frames(problem_, start.values, start.holds);
    const bool paper = settings_.commit.rule == CommitRule::kAtSize;
    if (!paper) s = solve_frames_choosing(problem_, s);
    if (s.valid) out_.all.push_back(hypothesis(std::move(s)));
  }

  [[nodiscard]] FrameHypothesis hypothesis(FrameSolution s) const {
    FrameHypothesis h;
    const std::size_t at = b_.keys.size();
    h.T_b_a = s.values.T_ref_odom[at];
    h.pivot_a_m = problem_.pivots_m[at];
    h.chi2 = s.chi2;
    h.prior_chi2 = s.prior_chi2;
    h.information = rigid(s.information, s);
    h.drift_information = rigid(s.drift_information, s);
    h.offset_information = rigid(s.offset_information, s);
    h.prior_information = rigid(s.prior_information, s);
    h.views = views(s.holds);
    for (std::size_t g = 0; g < s.holds.size(); ++g) {
      const bool prior = problem_.evidence[g].alternatives.front().source == EvidenceSource::kPrior;
      h.scans = h.scans || (s.holds[g] >= 0 && !prior);
      const EvidenceGroup& group = problem_.evidence[g];
      const bool between = (group.a.front() < at) != (group.b.front() < at);
      if (prior && between && s.holds[g] == kNoneHolds) ++h.priors_denied;
    }
    h.solution = std::move(s);
    return h;
  }

  /// Overlapping pieces show the same walls, so they share their error and count once.
  [[nodiscard]] int views(const std::vector<int>& holds) const {
    std::vector<const PoseEvidence*> held;
    for (std::size_t g = 0; g < holds.size(); ++g) {
      if (holds[g] < 0) continue;
      const PoseEvidence& e = problem_.evidence[g].alternatives[static_cast<std::size_t>(holds[g])];
      if (e.unrivalled) held.push_back(&e);
    }
    const double apart_m = settings_.commit.view_apart_m;
    std::size_t maximum = 0;
    for (const PoseEvidence* first : held) {  // starting in the middle would find fewer
      std::vector<const PoseEvidence*> seen = {first};
      for (const PoseEvidence* e : held) {
        const bool is_new = std::all_of(seen.begin(), seen.end(), [&](const PoseEvidence* s) {
          return (s->pivot_a_m - e->pivot_a_m).norm() >= apart_m &&
                 (s->place_b_m - e->place_b_m).norm() >= apart_m;
        });
        if (is_new) seen.push_back(e);
      }
      maximum = std::max(maximum, seen.size());
    }
    return static_cast<int>(maximum);
  }

  /// Information on the transform of group a as a rigid body, with b's frames fixed. The certainty
  /// of the frames within the groups was decided when they were joined.
  [[nodiscard]] Mat4 rigid(const Eigen::MatrixXd& information, const FrameSolution& s) const {
    const std::size_t at = b_.keys.size();
    const auto members = static_cast<Eigen::Index>(a_.keys.size());
    Eigen::Matrix<double, Eigen::Dynamic, 4> G(4 * members, 4);
    const Vec3 origin = s.values.T_ref_odom[at] * problem_.pivots_m[at];
    for (Eigen::Index k = 0; k < members; ++k) {
      const std::size_t f = at + static_cast<std::size_t>(k);
      const Vec3 arm = s.values.T_ref_odom[f] * problem_.pivots_m[f] - origin;
      Mat4 block = Mat4::Identity();
      block.block<3, 1>(1, 0) = quarter_turn(arm);
      G.block<4, 4>(4 * k, 0) = block;
    }
    const Mat4 out = G.transpose() * information.bottomRightCorner(4 * members, 4 * members) * G;
    return 0.5 * (out + out.transpose());
  }

  /// With one vehicle at standstill and no other evidence the heading is unobservable. Hypotheses
  /// that differ only by it are one; only the position from ranges distinguishes hypotheses.
  [[nodiscard]] bool same_but_heading(const FrameHypothesis& h, const FrameHypothesis& k) const {
    if (out_.a_stands == out_.b_stands) return false;
    for (const FrameHypothesis* each : {&h, &k}) {
      const std::vector<int>& holds = each->solution.holds;
      if (std::any_of(holds.begin(), holds.end(), [](int i) { return i >= 0; })) return false;
    }
    const Vec2& at = out_.a_stands ? out_.ranges.front().x_m : out_.ranges.front().y_m;
    const Vec3 antenna(at.x(), at.y(), 0.0);
    const Vec3 apart = out_.a_stands
                           ? Vec3(h.T_b_a * antenna - k.T_b_a * antenna)
                           : Vec3(h.T_b_a.inverse() * antenna - k.T_b_a.inverse() * antenna);
    return apart.norm() < settings_.search.merge_m;
  }

  /// Within three sigma. The place is that of the start, which may be far from where it was
  /// measured.
  [[nodiscard]] bool same_minimum(const FrameHypothesis& h, const FrameHypothesis& k) const {
    constexpr double kNear_chi2 = 9.0;
    Vec4 apart;
    apart[0] = wrapped(h.T_b_a.yaw_rad - k.T_b_a.yaw_rad);
    if (!one_place(0.0, apart[0], settings_.search)) return false;
    apart.tail<3>() = h.place_b_m() - k.place_b_m();
    return apart.dot(h.information * apart) < kNear_chi2 &&
           apart.dot(k.information * apart) < kNear_chi2;
  }

  /// Sorted hypotheses close to a cheaper one are merged into it. One that is a separate minimum
  /// and almost as good widens it: the true pose may be at either.
  void merge() {
    std::vector<FrameHypothesis> kept;
    for (FrameHypothesis& h : out_.all) {
      const auto same = std::find_if(kept.begin(), kept.end(), [&](const FrameHypothesis& k) {
        return same_place(k, h, settings_.search) || same_but_heading(k, h) || same_minimum(k, h);
      });
      if (same == kept.end()) {
        kept.push_back(std::move(h));
        continue;
      }
      const bool rival =
          h.chi2 - same->chi2 < settings_.commit.gap_chi2 && same_place(*same, h, settings_.search);
      Vec4 apart;
      apart[0] = wrapped(h.T_b_a.yaw_rad - same->T_b_a.yaw_rad);
      apart.tail<3>() = h.place_b_m() - same->place_b_m();
      const Vec4 known = same->information * apart;
      const double far = apart.dot(known);
      // Within a few sigma it is the same minimum, whose width is already in the information.
      if (rival && apart.tail<3>().norm() > kSameMinimum_m && far > settings_.commit.gap_chi2) {
        same->information -= known * known.transpose() / (1.0 + far);
      }
    }
    out_.all = std::move(kept);
  }

  static constexpr std::size_t kNoGroup = static_cast<std::size_t>(-1);

  const FrameGroup& a_;
  const FrameGroup& b_;
  const InitSettings& settings_;
  FrameProblem problem_;
  std::vector<FrameStart> starts_;
  HypothesisSet out_;
};

FrameGroup alone(StreamKey key) { return {{key}, {YawPose{}}}; }

}  // namespace

double HypothesisSet::inflation() const {
  if (all.empty() || all.front().solution.dof <= 0) return 1.0;
  return std::max(1.0, all.front().solution.fit_chi2 / all.front().solution.dof);
}

double HypothesisSet::gap(std::size_t k) const {
  return (all[k].chi2 - all.front().chi2) / inflation();
}

double HypothesisSet::gap_unobstructed(std::size_t k) const {
  return gap(k) - all[k].solution.obstructed_chi2 / inflation();
}

bool same_place(const FrameHypothesis& h, const FrameHypothesis& k,
                const SearchSettings& settings) {
  return one_place((h.place_b_m() - k.place_b_m()).norm(),
                   wrapped(h.T_b_a.yaw_rad - k.T_b_a.yaw_rad), settings);
}

HypothesisSet group_hypotheses(const FrameGroup& a, const FrameGroup& b,
                               const std::vector<PairTrack>& tracks,
                               const std::vector<PoseEvidence>& evidence,
                               const InitSettings& settings) {
  return Finder(a, b, tracks, evidence, settings).find();
}

HypothesisSet joint_hypotheses(const PairTrack& track, const std::vector<PoseEvidence>& evidence,
                               const InitSettings& settings) {
  return group_hypotheses(alone(track.a()), alone(track.b()), {track}, evidence, settings);
}

HypothesisSet range_hypotheses(const PairTrack& track, const InitSettings& settings) {
  return joint_hypotheses(track, {}, settings);
}

Mat4 pair_information(const PairTrack& track, const YawPose& T_b_a, const InitSettings& settings) {
  InitSettings as_given = settings;
  as_given.search.iterations = 0;
  const FrameProblem problem = make_frame_problem({track.b(), track.a()}, {track}, {}, as_given);
  FrameValues values;
  values.T_ref_odom = {YawPose{}, T_b_a};
  return solve_frames(problem, values, {}).information;
}

}  // namespace rali::fleet
