#include "rali/fleet/frames/frame_solver.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include <Eigen/Cholesky>

namespace rali::fleet {

using geometry::Vec3;

namespace {

/// Keeps the inverse finite in unobservable directions: 1000 m, 1000 rad.
constexpr double kTinyInformation = 1e-6;

bool holds(const FrameGroup& g, StreamKey key) {
  return std::find(g.keys.begin(), g.keys.end(), key) != g.keys.end();
}

/// Between a member of each.
bool between(const FrameGroup& a, const FrameGroup& b, StreamKey p, StreamKey q) {
  return (holds(a, p) && holds(b, q)) || (holds(a, q) && holds(b, p));
}

bool within(const FrameGroup& g, StreamKey p, StreamKey q) { return holds(g, p) && holds(g, q); }

}  // namespace

FrameSolver::FrameSolver(const InitSettings& settings, StreamKey reference)
    : settings_(settings), reference_(reference) {
  add_vehicle(reference);
}

void FrameSolver::add_vehicle(StreamKey key) {
  if (group_of(key)) return;
  Group group;
  group.frames.keys = {key};
  group.frames.T_ref_odom = {YawPose{}};
  groups_.push_back(std::move(group));
  std::sort(groups_.begin(), groups_.end(), [this](const Group& g, const Group& h) {
    const bool first_g = holds(g.frames, reference_);
    const bool first_h = holds(h.frames, reference_);
    if (first_g != first_h) return first_g;
    return g.frames.keys.front() < h.frames.keys.front();
  });
}

TrackUse FrameSolver::add_range(StreamKey a, StreamKey b, const RangeObservation& observation) {
  if (a == b) return TrackUse::kRefused;
  add_vehicle(a);
  add_vehicle(b);
  if (b < a) {
    RangeObservation o = observation;
    std::swap(o.x_a_m, o.y_b_m);
    std::swap(o.x_covariance_m2, o.y_covariance_m2);
    std::swap(o.a_rests, o.b_rests);
    return add_range(b, a, o);
  }
  return tracks_.try_emplace({a, b}, a, b, settings_.track).first->second.add(observation);
}

void FrameSolver::add_evidence(const PoseEvidence& evidence) {
  if (evidence.a == evidence.b) return;
  add_vehicle(evidence.a);
  add_vehicle(evidence.b);
  evidence_.push_back(evidence);
}

std::optional<std::size_t> FrameSolver::group_of(StreamKey key) const {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    if (holds(groups_[g].frames, key)) return g;
  }
  return std::nullopt;
}

std::vector<PairTrack> FrameSolver::tracks_of(const FrameGroup& a, const FrameGroup& b) const {
  std::vector<PairTrack> out;
  for (const auto& [pair, track] : tracks_) {
    const bool wanted = between(a, b, pair.first, pair.second) ||
                        within(a, pair.first, pair.second) || within(b, pair.first, pair.second);
    if (wanted) out.push_back(track);
  }
  return out;
}

std::size_t FrameSolver::received_between(const FrameGroup& a, const FrameGroup& b) const {
  const auto news = static_cast<std::size_t>(settings_.commit.new_ranges);
  std::size_t received = 0;
  for (const auto& [pair, track] : tracks_) {
    if (between(a, b, pair.first, pair.second)) received += track.received();
  }
  // A piece of evidence alone triggers an evaluation, a few more ranges do not.
  for (const PoseEvidence& e : evidence_) {
    if (between(a, b, e.a, e.b)) received += news;
  }
  return received;
}

int FrameSolver::keyframes(const FrameGroup& a, const FrameGroup& b) const {
  const auto maximum = [this](const FrameGroup& g) {
    int n = 0;
    for (const StreamKey key : g.keys) {
      const auto at = keyframes_.find(key);
      if (at != keyframes_.end()) n = std::max(n, at->second);
    }
    return n;
  };
  // Preset paper: the size of the tag's map counts, because a standing anchor has only one
  // keyframe.
  const bool of_either = settings_.commit.rule == CommitRule::kAtSize;
  return of_either ? std::max(maximum(a), maximum(b)) : std::min(maximum(a), maximum(b));
}

/// @return true if a is to be joined to b
bool FrameSolver::look(Time t, const Group& a, const Group& b) {
  const std::size_t received = received_between(a.frames, b.frames);
  if (received == 0) return false;
  const KeyPair key(a.frames.keys.front(), b.frames.keys.front());
  const std::size_t members = a.frames.keys.size() + b.frames.keys.size();
  auto at = links_.find(key);
  if (at == links_.end()) {
    at = links_.emplace(key, Link{0, 0, {}, {}, {}, CommitGate(settings_)}).first;
  }
  Link& link = at->second;
  const auto news = static_cast<std::size_t>(settings_.commit.new_ranges);
  const bool anew =
      link.received == 0 || received >= link.received + news || members != link.members;
  if (anew) {
    link.received = received;
    link.members = members;
    link.set =
        group_hypotheses(a.frames, b.frames, tracks_of(a.frames, b.frames), evidence_, settings_);
    link.seen = observability(link.set, settings_);
  }
  link.decision = decide(link.set, link.seen, keyframes(a.frames, b.frames), settings_);
  const FrameHypothesis* chosen =
      link.set.all.empty() ? nullptr : &link.set.all[link.decision.chosen];
  return link.gate.evaluate(t, link.decision, chosen);
}

void FrameSolver::evaluate(Time t) {
  std::set<KeyPair> looked;
  bool again = true;
  while (again) {
    again = false;
    for (std::size_t b = 0; b < groups_.size() && !again; ++b) {
      for (std::size_t a = b + 1; a < groups_.size() && !again; ++a) {
        const KeyPair key(groups_[a].frames.keys.front(), groups_[b].frames.keys.front());
        if (!looked.insert(key).second) continue;
        if (!look(t, groups_[a], groups_[b])) continue;
        join(a, b);
        again = true;
      }
    }
  }
  if (settings_.freeze) return;
  for (Group& group : groups_) {
    if (group.frames.keys.size() > 1) solve(group, false);
  }
}

/// Group a becomes part of b.
void FrameSolver::join(std::size_t a, std::size_t b) {
  Group& into = groups_[b];
  const FrameGroup from = groups_[a].frames;
  const auto link = links_.find({from.keys.front(), into.frames.keys.front()});
  const DecidedBy by = link->second.decision.by;
  for (const StreamKey key : from.keys) {
    const auto before = groups_[a].by.find(key);
    const bool prior = before != groups_[a].by.end() && before->second == DecidedBy::kPrior;
    into.by[key] = prior ? DecidedBy::kPrior : by;
  }
  const std::size_t chosen = link->second.decision.chosen;
  into.held_priors.insert(groups_[a].held_priors.begin(), groups_[a].held_priors.end());
  for (const PoseEvidence& e : evidence_) {
    const bool linked = e.source == EvidenceSource::kPrior && between(from, into.frames, e.a, e.b);
    if (linked && link->second.set.all[chosen].priors_denied == 0) {
      into.held_priors.emplace(e.a, e.b);
    }
  }
  into.frames.keys.insert(into.frames.keys.end(), from.keys.begin(), from.keys.end());
  into.frames.T_ref_odom = link->second.set.all[chosen].solution.values.T_ref_odom;
  solve(into, true);
  groups_.erase(groups_.begin() + static_cast<std::ptrdiff_t>(a));
  std::erase_if(links_, [&](const auto& item) {
    return item.first.first == from.keys.front() || item.first.second == from.keys.front();
  });
}

void FrameSolver::take(Group& group, const FrameProblem& problem, const FrameSolution& solution) {
  group.frames.T_ref_odom = solution.values.T_ref_odom;
  const Eigen::Index n = problem.frame_size();
  Eigen::MatrixXd information = solution.information;
  information.diagonal().array() += kTinyInformation;
  // From (yaw, pivot position) to (yaw, translation): t = position - R pivot.
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(n, n);
  for (std::size_t f = 1; f < problem.keys.size(); ++f) {
    const Eigen::Index at = 4 * (static_cast<Eigen::Index>(f) - 1);
    const Vec3 arm = group.frames.T_ref_odom[f].turned(problem.pivots_m[f]);
    A.block<3, 1>(at + 1, at) = -quarter_turn(arm);
  }
  const Eigen::MatrixXd covariance = information.ldlt().solve(Eigen::MatrixXd::Identity(n, n));
  group.covariance = A * covariance * A.transpose();
}

void FrameSolver::solve(Group& group, bool anew) {
  const std::size_t received = received_between(group.frames, group.frames);
  const auto news = static_cast<std::size_t>(settings_.commit.new_ranges);
  if (!anew && received < group.received + news) return;
  group.received = received;
  const FrameProblem problem = make_frame_problem(
      group.frames.keys, tracks_of(group.frames, group.frames), evidence_, settings_);
  const bool choose = settings_.commit.rule == CommitRule::kCertain;
  FrameValues start;
  start.T_ref_odom = group.frames.T_ref_odom;
  std::vector<int> holds = best_alternatives(problem, start, choose);
  // The start pose by which a vehicle was placed: ranges through walls must not overrule it now.
  std::set<std::size_t> kept;
  for (std::size_t g = 0; g < problem.evidence.size(); ++g) {
    const PoseEvidence& e = problem.evidence[g].alternatives.front();
    const bool decided = group.held_priors.contains({e.a, e.b});
    if (e.source != EvidenceSource::kPrior || !decided) continue;
    holds[g] = 0;
    kept.insert(g);
  }
  FrameSolution s = solve_frames(problem, start, holds);
  if (choose) s = solve_frames_choosing(problem, s, kept);
  if (s.valid) take(group, problem, s);
}

void FrameSolver::place(const PoseEvidence& known) {
  if (known.a == known.b) return;
  add_evidence(known);
  const std::size_t a = *group_of(known.a);
  const std::size_t b = *group_of(known.b);
  if (a == b || groups_[a].frames.keys.size() > 1) return;
  Group& into = groups_[b];
  const auto k = std::find(into.frames.keys.begin(), into.frames.keys.end(), known.b);
  const YawPose T = into.frames.T_ref_odom[static_cast<std::size_t>(k - into.frames.keys.begin())];
  into.frames.keys.push_back(known.a);
  into.frames.T_ref_odom.push_back(T * known.T_b_a());
  into.by[known.a] = DecidedBy::kRanges;
  solve(into, true);
  groups_.erase(groups_.begin() + static_cast<std::ptrdiff_t>(a));
  links_.clear();
}

}  // namespace rali::fleet
