#include "rali/fleet/centre/group_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "rali/fleet/centre/scan_evidence.hpp"
#include "rali/fleet/centre/start_check.hpp"

namespace rali::fleet {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;

Mat6 relative_covariance(const SE3& T_i, const SE3& T_j,
                         const Eigen::Matrix<double, 12, 12>& joint) {
  const Mat3 R_ti = T_i.R.transpose();
  Eigen::Matrix<double, 6, 12> J = Eigen::Matrix<double, 6, 12>::Zero();
  J.block<3, 3>(0, 0) = -T_j.R.transpose() * T_i.R;
  J.block<3, 3>(0, 6).setIdentity();
  J.block<3, 3>(3, 0) = geometry::skew(R_ti * (T_j.p - T_i.p));
  J.block<3, 3>(3, 3) = -R_ti;
  J.block<3, 3>(3, 9) = R_ti;
  return J * joint * J.transpose();
}

/// Converts from the bodies to the submaps' frames: the origins are the same.
places::Guess guess_of(const PathSubmap& target, const PathSubmap& source, const SE3& T_map_target,
                       const SE3& T_map_source, const Mat6& P) {
  Mat6 turn = Mat6::Zero();
  turn.topLeftCorner<3, 3>() = source.submap.T_ref_body().R;
  turn.bottomRightCorner<3, 3>() = target.submap.T_ref_body().R;
  places::Guess guess;
  guess.T_target_source = target.submap.T_ref_body() * (T_map_target.inverse() * T_map_source) *
                          source.submap.T_ref_body().inverse();
  guess.covariance = turn * P * turn.transpose();
  return guess;
}

namespace {

/// Reason in loops.csv for a comparison that gave no loop.
std::string refusal_of(const places::Recognition& r) {
  if (r.found()) return "ambiguous";
  if (r.refusal == places::Refusal::kNone) return "no_match";
  return fmt::format("no_match:{}", places::kRefusalNames[static_cast<std::size_t>(r.refusal)]);
}

/// Estimate of one group in progress.
class Group {
 public:
  Group(const GroupInput& input, std::size_t group)
      : in_(input),
        members_(input.frames.groups[group]),
        joint_(graph_of(input, group)),
        memory_(input.memory != nullptr ? *input.memory : own_memory_) {
    joint_.stop_on(in_.stop);
    for (const StartPrior& start : in_.starts) {
      if (has(start.path) && has(start.relative_to)) add_start(start);
    }
    joint_.add(in_.ranges, in_.bias_m);
    if (in_.settings.loops.use) add_loops_of_frames();
    joint_.solve();
  }

  void close_loops(Executor& executor);
  void ask_starts_again();
  void report(std::size_t group, FleetEstimate& out);

  [[nodiscard]] SeparatorPrior separator(Time until) { return joint_.separator(until); }

 private:
  static JointGraph graph_of(const GroupInput& input, std::size_t group);

  [[nodiscard]] bool has(std::size_t path) const {
    return std::find(members_.begin(), members_.end(), path) != members_.end();
  }

  void add_start(const StartPrior& start);
  [[nodiscard]] std::optional<places::Guess> guess(std::size_t target, std::size_t source);
  void remember(const Loop& loop);
  void add_loops_of_frames();
  [[nodiscard]] LoopVerdict verdict_of(const Loop& loop) const;
  bool look_once(Executor& executor);
  void note(const LoopFound& found);
  void judge(const std::vector<LoopMemory::Pair>& pairs, Executor& executor);
  [[nodiscard]] Time time_of(KeyframeId keyframe) const;
  void report_paths(std::size_t group, FleetEstimate& out);
  void report_loops(FleetEstimate& out);

  const GroupInput& in_;
  const std::vector<std::size_t>& members_;
  JointGraph joint_;
  LoopMemory own_memory_;
  LoopMemory& memory_;
  std::vector<LoopVerdict> loops_;
  std::vector<RejectedStart> rejected_;
  std::vector<StartPrior> rejected_starts_;  ///< in the same order
  std::size_t closed_ = 0;
};

JointGraph Group::graph_of(const GroupInput& input, std::size_t group) {
  std::vector<std::optional<SE3>> T_map_odom(input.paths.size());
  for (const std::size_t path : input.frames.groups[group]) {
    T_map_odom[path] = input.frames.T_map_odom[path];
  }
  const auto in_group = [&](std::size_t path) { return T_map_odom[path].has_value(); };
  const bool ranged =
      std::any_of(input.ranges.pairs.begin(), input.ranges.pairs.end(),
                  [&](const AntennaPair& p) { return in_group(p.a.path) && in_group(p.b.path); });
  return {input.paths,          T_map_odom,
          input.settings.joint, input.settings.ranging,
          input.before,         ranged ? DegenerateSteps::kInertial : DegenerateSteps::kFilter};
}

/// A start pose rejected in the frame search must not bend the paths now.
void Group::add_start(const StartPrior& start) {
  const RejectedStart off = off_start(in_.paths, start, in_.frames.T_map_odom[start.relative_to],
                                      in_.frames.T_map_odom[start.path]);
  if (!contradicts(start, off, in_.settings.init.prior)) return joint_.add(start);
  rejected_.push_back(off);
  rejected_starts_.push_back(start);
}

/// The frame search knows the frames less accurately than paths, ranges and loops together: along a
/// bare passage it may be metres off a start pose that the finished solution confirms.
void Group::ask_starts_again() {
  const auto T_map_odom = [this](std::size_t path) {
    const SE3& T_odom_body = in_.paths[path].nodes().front().step->T_odom_body;
    return joint_.T_map_body(path, 0) * T_odom_body.inverse();
  };
  const auto starts_now = [this](std::size_t path) { return joint_.begin(path) == 0; };
  bool confirmed = false;
  std::vector<RejectedStart> rejected;
  for (std::size_t k = 0; k < rejected_.size(); ++k) {
    const StartPrior& start = rejected_starts_[k];
    RejectedStart off = rejected_[k];
    if (starts_now(start.relative_to) && starts_now(start.path)) {
      off = off_start(in_.paths, start, T_map_odom(start.relative_to), T_map_odom(start.path));
    }
    if (contradicts(start, off, in_.settings.init.prior)) {
      rejected.push_back(off);
      continue;
    }
    joint_.add(start);
    confirmed = true;
  }
  rejected_ = std::move(rejected);
  rejected_starts_.clear();
  if (confirmed) joint_.solve();
}

/// From the graph's covariance, plus the error of the vehicles' own maps.
std::optional<places::Guess> Group::guess(std::size_t target, std::size_t source) {
  if (in_.stop.raised()) return std::nullopt;
  const PathSubmap& t = in_.submaps[target];
  const PathSubmap& s = in_.submaps[source];
  if (!has(t.path) || !has(s.path)) return std::nullopt;
  const SE3 T_t = joint_.T_map_body(t.path, t.node);
  const SE3 T_s = joint_.T_map_body(s.path, s.node);
  // Far beyond any pose uncertainty: the covariance need not be computed.
  constexpr double kUncertaintyMax_m = 30.0;
  if ((T_t.p - T_s.p).norm() > in_.settings.places.near.view_m + kUncertaintyMax_m)
    return std::nullopt;
  Mat6 P = relative_covariance(
      T_t, T_s, joint_.graph().covariance(joint_.seq(t.path, t.node), joint_.seq(s.path, s.node)));
  // Only the growth since the separator: an uncertainty that grows with the mission would make
  // every pair a candidate.
  const auto own = [this](std::size_t path, std::size_t from, std::size_t to) -> geometry::Vec6 {
    const auto& nodes = in_.paths[path].nodes();
    return (nodes[to].step->covariance - nodes[from].step->covariance).diagonal().cwiseAbs();
  };
  if (t.path == s.path) {
    P.diagonal() += own(t.path, t.node, s.node);
  } else {
    P.diagonal() += own(t.path, joint_.begin(t.path), t.node);
    P.diagonal() += own(s.path, joint_.begin(s.path), s.node);
  }
  return guess_of(t, s, T_t, T_s, P);
}

/// Stores a comparison of pieces of this group as a loop that is not tested yet.
void Group::remember(const Loop& loop) {
  if (!joint_.seq(loop.from) || !joint_.seq(loop.to)) return;
  if (memory_.compared.emplace(loop.from, loop.to).second) {
    memory_.loops[{loop.from, loop.to}] = loop;
  }
  if (memory_.loops.contains({loop.from, loop.to})) memory_.of_frames.emplace(loop.from, loop.to);
}

/// The frame search has weighed these loops against start poses, ranges and one another. A graph of
/// start poses and ranges alone may be off by more than its sigmas. Tested one by one against it,
/// all loops would be rejected, and the paths would disagree with the frames.
void Group::add_loops_of_frames() {
  for (const Loop& loop : in_.seen) remember(loop);
  for (const LoopMemory::Pair& pair : memory_.of_frames) {
    const Loop& loop = memory_.loops.at(pair);
    const auto from = joint_.seq(loop.from), to = joint_.seq(loop.to);
    if (!from || !to) continue;
    LoopVerdict verdict = verdict_of(loop);
    verdict.accepted = true;
    verdict.reason = "accepted";
    const SE3 T_from_to = joint_.graph().pose(*from).inverse() * joint_.graph().pose(*to);
    verdict.shift_m = (T_from_to.p - loop.T_from_to.p).norm();
    joint_.add_loop(loops_.size(), loop);
    loops_.push_back(verdict);
  }
}

LoopVerdict Group::verdict_of(const Loop& loop) const {
  LoopVerdict verdict;
  verdict.from = loop.from;
  verdict.to = loop.to;
  verdict.t_from = time_of(loop.from);
  verdict.t_to = time_of(loop.to);
  verdict.T_from_to = loop.T_from_to;
  verdict.information = loop.information;
  verdict.score = loop.overlap;
  return verdict;
}

void Group::close_loops(Executor& executor) {
  if (!in_.settings.loops.use) return;
  std::vector<LoopMemory::Pair> known;
  for (const auto& [pair, loop] : memory_.loops) {
    if (!memory_.of_frames.contains(pair)) known.push_back(pair);
  }
  if (!known.empty()) {
    judge(known, executor);
    if (!joint_.graph().loops().empty()) joint_.solve();
  }
  for (int pass = 0; pass < in_.settings.loops.passes && !in_.stop.raised(); ++pass) {
    if (!look_once(executor)) return;
    joint_.solve();
  }
}

/// @return false if there was nothing new to compare
bool Group::look_once(Executor& executor) {
  const places::PlacesSettings& places = in_.settings.places;
  std::vector<LoopCandidate> candidates = near_candidates(
      in_.submaps, [this](std::size_t t, std::size_t s) { return guess(t, s); }, places.near,
      in_.settings.loops);
  std::erase_if(candidates, [this](const LoopCandidate& c) {
    return !memory_.compared
                .emplace(in_.submaps[c.target].submap.middle(),
                         in_.submaps[c.source].submap.middle())
                .second;
  });
  if (candidates.empty()) return false;
  std::vector<LoopMemory::Pair> fresh;
  for (const LoopFound& found :
       compare_all(in_.submaps, std::move(candidates), places.recognise, executor, in_.stop)) {
    note(found);
    if (!found.recognition.usable()) continue;
    const Loop loop = loop_of(in_.submaps, found, in_.settings.loops.bend_per_m);
    fresh.emplace_back(loop.from, loop.to);
    memory_.loops[fresh.back()] = loop;
  }
  judge(fresh, executor);
  return true;
}

/// Comparisons without a match are reported, too.
void Group::note(const LoopFound& found) {
  if (found.recognition.usable()) return;
  const PathSubmap& target = in_.submaps[found.candidate.target];
  const PathSubmap& source = in_.submaps[found.candidate.source];
  LoopVerdict verdict;
  verdict.from = target.submap.middle();
  verdict.to = source.submap.middle();
  verdict.t_from = in_.paths[target.path].nodes()[target.node].t;
  verdict.t_to = in_.paths[source.path].nodes()[source.node].t;
  verdict.reason = refusal_of(found.recognition);
  loops_.push_back(verdict);
}

/// Tests each loop on its own against paths and ranges, before one can support another (the veto of
/// 8.4). Loops of other groups, or of nodes before the separator, are skipped.
void Group::judge(const std::vector<LoopMemory::Pair>& pairs, Executor& executor) {
  std::vector<graph::RelativePoseFactor> asked;
  std::vector<const Loop*> loops;
  const std::size_t first = loops_.size();
  for (const LoopMemory::Pair& pair : pairs) {
    const Loop& loop = memory_.loops.at(pair);
    const auto from = joint_.seq(loop.from), to = joint_.seq(loop.to);
    if (!from || !to) continue;
    asked.push_back({*from, *to, loop.T_from_to, loop.information});
    loops.push_back(&loop);
    loops_.push_back(verdict_of(loop));
  }
  const std::vector<graph::LoopVerdict> judged = joint_.graph().judge(asked, executor);
  for (std::size_t k = 0; k < judged.size(); ++k) {
    LoopVerdict& verdict = loops_[first + k];
    const Vec3 shift_m = judged[k].T_i_j.p - verdict.T_from_to.p;
    verdict.shift_m = shift_m.norm();
    const bool vetoed = in_.settings.loops.veto && judged[k].vetoed();
    const bool slid = slide_m(verdict.information, shift_m) > in_.settings.loops.slide_max_m;
    verdict.accepted = !vetoed && !slid;
    verdict.reason = vetoed ? "veto" : slid ? "slid" : "accepted";
    if (verdict.accepted) joint_.add_loop(first + k, *loops[k]);
  }
}

Time Group::time_of(KeyframeId keyframe) const {
  for (const std::size_t path : members_) {
    if (in_.paths[path].vehicle() != keyframe.vehicle) continue;
    const auto node = in_.paths[path].node_of(keyframe.seq);
    if (node) return in_.paths[path].nodes()[*node].t;
  }
  return {};
}

void Group::report(std::size_t group, FleetEstimate& out) {
  report_loops(out);
  report_paths(group, out);
  out.rejected_starts.insert(out.rejected_starts.end(), rejected_.begin(), rejected_.end());
}

/// The solver makes the final decision on a loop: it may have switched it off.
void Group::report_loops(FleetEstimate& out) {
  for (const graph::LoopState& state : joint_.graph().loops()) {
    LoopVerdict& verdict = loops_[state.id];
    if (state.weight >= 0.5) {
      ++closed_;
      continue;
    }
    verdict.accepted = false;
    verdict.reason = "contradicts_others";
  }
  out.loops.insert(out.loops.end(), loops_.begin(), loops_.end());
  std::stable_sort(out.loops.begin(), out.loops.end(),
                   [](const LoopVerdict& a, const LoopVerdict& b) {
                     return std::max(a.t_from, a.t_to) < std::max(b.t_from, b.t_to);
                   });
}

void Group::report_paths(std::size_t group, FleetEstimate& out) {
  std::vector<VehicleId> ids;
  const bool changed = members_.size() > 1 || closed_ > 0 || in_.before != nullptr;
  for (const std::size_t path : members_) {
    const VehiclePath& p = in_.paths[path];
    ids.push_back(p.vehicle());
    VehicleFrame& frame = out.frames[path];
    frame.vehicle = p.vehicle();
    frame.epoch = p.epoch();
    frame.group = group;
    frame.decided_by = in_.frames.decided_by[path];
    const std::size_t first = joint_.begin(path);
    frame.T_map_odom =
        joint_.T_map_body(path, first) * p.nodes()[first].step->T_odom_body.inverse();
    const Mat6 P = joint_.covariance(path, first);
    frame.sigma_m = std::sqrt(std::max(0.0, P(3, 3) + P(4, 4)));
    frame.sigma_rad = std::sqrt(std::max(0.0, P(2, 2)));
    for (std::size_t k = first; changed && k < p.nodes().size(); ++k) {
      const Increment& step = *p.nodes()[k].step;
      if (!step.keyframe) continue;
      out.keyframes[{p.vehicle(), *step.keyframe}] = {p.nodes()[k].t, joint_.T_map_body(path, k),
                                                      joint_.covariance(path, k)};
    }
  }
  out.groups.push_back(std::move(ids));
  if (!changed) return;
  for (const PairBias& bias : joint_.biases()) out.biases.push_back(bias);
  for (const UsedRange& range : joint_.used_ranges()) out.ranges.push_back(range);
}

}  // namespace

std::vector<SeparatorPrior> estimate_group(const GroupInput& input, std::size_t group,
                                           Executor& executor, FleetEstimate& out,
                                           std::span<const Time> ends) {
  out.frames.resize(input.paths.size());
  Group work(input, group);
  work.close_loops(executor);
  work.ask_starts_again();
  if (input.stop.raised()) return {};
  work.report(group, out);
  std::vector<SeparatorPrior> boundaries;
  for (const Time end : ends) boundaries.push_back(work.separator(end));
  return boundaries;
}

}  // namespace rali::fleet
