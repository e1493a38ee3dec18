#include "rali/fleet/centre/round_centre.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>

#include "rali/fleet/centre/joint_graph.hpp"
#include "rali/fleet/centre/path_frames.hpp"

namespace rali::fleet {

using geometry::SE3;

namespace {

std::size_t nodes_from(std::span<const VehiclePath> paths, std::span<const std::size_t> begins) {
  std::size_t n = 0;
  for (std::size_t i = 0; i < paths.size(); ++i) n += paths[i].nodes().size() - begins[i];
  return n;
}

}  // namespace

RoundCentre::RoundCentre(const FleetSettings& settings, FleetKnowledge knowledge)
    : centre_(settings, std::move(knowledge)),
      history_(static_cast<std::size_t>(settings.separator.kept)) {}

const FleetEstimate& RoundCentre::estimate(Executor& executor, StopFlag stop) {
  solve(std::nullopt, executor, stop);
  return last_;
}

const FleetEstimate& RoundCentre::end_round(Time t, Executor& executor, StopFlag stop) {
  solve(end_of(t), executor, stop);
  return last_;
}

/// Vehicles without facts since the last separator are ignored.
Time RoundCentre::end_of(Time t) const {
  Time end = t;
  for (const VehiclePath& path : paths()) {
    const Time last = path.nodes().back().t;
    if (!separator_ || last > separator_->until) end = std::min(end, last);
  }
  return end;
}

RoundCentre::Saved RoundCentre::saved() const {
  return {done_, separator_, history_, cut_from_, memory_};
}

void RoundCentre::restore(Saved saved) {
  done_ = std::move(saved.done);
  separator_ = std::move(saved.separator);
  history_ = std::move(saved.history);
  cut_from_ = std::move(saved.cut_from);
  memory_ = std::move(saved.memory);
}

void RoundCentre::solve(std::optional<Time> until, Executor& executor, StopFlag stop) {
  if (stop.raised()) return;
  stop_ = stop;
  if (centre_.settings().solve == SolveWhat::kAll || paths().size() < 2) {
    FleetEstimate estimate = centre_.estimate(executor, &compared_, stop);
    if (!stop.raised()) last_ = std::move(estimate);
    for (const VehiclePath& path : paths()) work_.all_nodes += path.nodes().size();
    ++work_.whole;
    stop_ = {};
    return;
  }
  find_pieces();
  std::vector<Time> ends;
  if (until) ends.push_back(*until);
  Saved before = saved();
  const bool done = separator_holds() ? solve_from_separator(std::move(ends), executor)
                                      : solve_all(std::move(ends), executor);
  stop_ = {};
  if (done) return;
  restore(std::move(before));
  static_cast<void>(keep_finished(std::move(pieces_)));
}

bool RoundCentre::solve_from_separator(std::vector<Time> ends, Executor& executor) {
  // Taken before any round is solved again: afterwards the last rounds are different ones, and each
  // loop would lead one round further back.
  const std::vector<std::size_t> lately =
      history_.begins(paths(), static_cast<std::size_t>(centre_.settings().separator.near_rounds));
  for (std::size_t steps = 1;; steps *= 2) {
    Solution solution = solve_round(ends, executor);
    const std::vector<std::size_t> back_to = look_back(solution, lately, executor);
    if (stop_.raised()) {
      pieces_ = std::move(solution.pieces);
      return false;
    }
    const bool moved = separator_moved(solution.estimate);
    const bool closes = back_to != begins();
    std::vector<PathSubmap> of_round = keep_finished(std::move(solution.pieces));
    if (!closes && !moved) {
      merge(std::move(solution.estimate));
      if (solution.boundaries.empty()) return true;
      take(std::move(solution.boundaries));
      finish(std::move(of_round));
      return true;
    }
    if (!go_back(back_to, moved ? steps : 1, ends)) return solve_all(std::move(ends), executor);
  }
}

void RoundCentre::take(std::vector<SeparatorPrior> boundaries) {
  for (SeparatorPrior& separator : boundaries) {
    if (separator_) history_.push(std::move(*separator_));
    separator_ = std::move(separator);
  }
}

/// Nodes before the separator are not cut again, nor those before a later one that was dropped.
void RoundCentre::cut_on() {
  const std::vector<std::size_t> first = begins();
  cut_from_.resize(first.size(), 0);
  for (std::size_t i = 0; i < first.size(); ++i) cut_from_[i] = std::max(cut_from_[i], first[i]);
}

/// Pieces of finished rounds are kept, whatever separator they were solved on: their points may be
/// freed.
/// @return the others
std::vector<PathSubmap> RoundCentre::keep_finished(std::vector<PathSubmap> pieces) {
  cut_on();
  const auto others = std::stable_partition(
      pieces.begin(), pieces.end(),
      [&](const PathSubmap& piece) { return piece.node < cut_from_[piece.path]; });
  pieces_.assign(std::move_iterator(pieces.begin()), std::move_iterator(others));
  return {std::move_iterator(others), std::move_iterator(pieces.end())};
}

/// Prepares solving again from an earlier separator. @return false if there is none before these
/// nodes
/// @param ends of rounds that get a separator again are put in front
bool RoundCentre::go_back(std::span<const std::size_t> nodes, std::size_t steps,
                          std::vector<Time>& ends) {
  if (ends.empty() || ends.front() > separator_->until) {
    ends.insert(ends.begin(), separator_->until);
  }
  std::optional<SeparatorPrior> earlier = history_.take(paths(), nodes, steps, ends);
  if (!earlier || !JointGraph::fits(*earlier, paths(), centre_.settings().joint)) return false;
  separator_ = std::move(earlier);
  keep_done();
  ++work_.reopened;
  return true;
}

/// All paths must exist and be joined: a vehicle that comes later is joined by all facts.
bool RoundCentre::separator_holds() const {
  return separator_ && separator_->paths.size() == paths().size() &&
         JointGraph::fits(*separator_, paths(), centre_.settings().joint);
}

Solution RoundCentre::solve_for(SolutionInput in, Executor& executor) {
  in.memory = &memory_;
  in.pieces = std::exchange(pieces_, {});
  in.cut_from = cut_from_;
  in.stop = stop_;
  Solution solution = solve_fleet(std::move(in), executor);
  work_.all_nodes += work_.nodes;
  work_.cut += solution.cut;
  work_.compared += solution.compared;
  return solution;
}

Solution RoundCentre::solve_round(std::vector<Time> ends, Executor& executor) {
  ++work_.rounds;
  work_.nodes = nodes_from(paths(), begins());
  SolutionInput in{
      .paths = paths(), .knowledge = centre_.knowledge(), .settings = centre_.settings()};
  in.before = &*separator_;
  in.ends = std::move(ends);
  return solve_for(std::move(in), executor);
}

bool RoundCentre::solve_all(std::vector<Time> ends, Executor& executor) {
  ++work_.whole;
  if (ends.empty() && separator_) ends.push_back(separator_->until);
  work_.nodes = nodes_from(paths(), std::vector<std::size_t>(paths().size(), 0));
  SolutionInput in{
      .paths = paths(), .knowledge = centre_.knowledge(), .settings = centre_.settings()};
  in.frames = frames_;
  in.compared = &compared_;
  in.ends = std::move(ends);
  Solution solution = solve_for(std::move(in), executor);
  if (stop_.raised()) {
    pieces_ = std::move(solution.pieces);
    return false;
  }
  done_ = {};
  separator_.reset();
  history_.clear();
  cut_from_.assign(paths().size(), 0);
  last_ = std::move(solution.estimate);
  if (last_.groups.size() != 1) {
    frames_.reset();
    finish({});
    return true;
  }
  frames_ = std::move(solution.frames);
  take(std::move(solution.boundaries));
  finish(std::move(solution.pieces));
  return true;
}

std::vector<std::size_t> RoundCentre::begins() const {
  return begins_of(paths(), separator_ ? &*separator_ : nullptr);
}

/// A separator prior is linearised; one that moves far was wrong.
bool RoundCentre::separator_moved(const FleetEstimate& estimate) const {
  const SeparatorSettings& s = centre_.settings().separator;
  for (const SeparatorPath& known : separator_->paths) {
    for (std::size_t i = 0; i < paths().size(); ++i) {
      if (stream_of(paths()[i]) != known.stream) continue;
      const auto node = paths()[i].index_of(known.node);
      if (!node) return true;
      const SE3 T = estimate.frames[i].T_map_odom * paths()[i].nodes()[*node].step->T_odom_body;
      const geometry::Vec6 moved = geometry::boxminus(T, known.T_map_body);
      for (int k = 0; k < 6; ++k) {
        const double sigma = std::sqrt(std::max(0.0, known.covariance(k, k)));
        if (std::abs(moved[k]) > s.moved_sigma * sigma + s.moved_m) return true;
      }
    }
  }
  return false;
}

/// Combines finished rounds and the live one into one estimate.
void RoundCentre::merge(FleetEstimate live) {
  last_ = done_;
  last_.keyframes.merge(live.keyframes);
  last_.loops.insert(last_.loops.end(), live.loops.begin(), live.loops.end());
  last_.ranges.insert(last_.ranges.end(), live.ranges.begin(), live.ranges.end());
  last_.biases = std::move(live.biases);
  std::stable_sort(last_.loops.begin(), last_.loops.end(),
                   [](const LoopVerdict& a, const LoopVerdict& b) {
                     return std::max(a.t_from, a.t_to) < std::max(b.t_from, b.t_to);
                   });
}

/// Nodes before the separator are finished: they keep the poses of the last estimate.
void RoundCentre::keep_done() {
  const std::vector<std::size_t> first = begins();
  const auto is_done = [&](KeyframeId id) {
    for (std::size_t i = 0; i < paths().size(); ++i) {
      if (paths()[i].vehicle() != id.vehicle) continue;
      const auto node = paths()[i].node_of(id.seq);
      if (node) return *node < first[i];
    }
    return true;
  };
  done_ = last_;
  std::erase_if(done_.keyframes, [&](const auto& entry) { return !is_done(entry.first); });
  std::erase_if(done_.loops,
                [&](const LoopVerdict& loop) { return !is_done(loop.from) && !is_done(loop.to); });
  std::erase_if(done_.ranges,
                [&](const UsedRange& range) { return !is_done(range.a) && !is_done(range.b); });
}

void RoundCentre::finish(std::vector<PathSubmap> pieces) {
  keep_done();
  cut_on();
  for (PathSubmap& piece : pieces) {
    if (piece.node < cut_from_[piece.path]) keep(std::move(piece));
  }
  work_.pieces = pieces_.size();
}

/// A fleet that drives over the same ground repeatedly keeps one piece of each place.
void RoundCentre::keep(PathSubmap piece) {
  const SeparatorSettings& s = centre_.settings().separator;
  const auto at = last_.keyframes.find(piece.submap.middle());
  const auto same = [&](const PathSubmap& other) {
    const auto there = last_.keyframes.find(other.submap.middle());
    if (at == last_.keyframes.end() || there == last_.keyframes.end()) return false;
    const geometry::Vec6 apart =
        geometry::boxminus(at->second.T_map_body, there->second.T_map_body);
    return apart.tail<3>().norm() < s.same_place_m &&
           apart.head<3>().norm() < kDegree * s.same_place_deg;
  };
  if (std::none_of(pieces_.begin(), pieces_.end(), same)) pieces_.push_back(std::move(piece));
}

/// New paths, or nodes that were in transit, may have arrived: pieces are located again by their
/// middles.
void RoundCentre::find_pieces() {
  std::vector<StreamKey> streams;
  for (const VehiclePath& path : paths()) streams.push_back(stream_of(path));
  if (streams != streams_) {
    pieces_.clear();
    cut_from_.assign(streams.size(), 0);
    frames_.reset();
    history_.clear();
    streams_ = std::move(streams);
  }
  for (PathSubmap& piece : pieces_) {
    const auto node = paths()[piece.path].node_of(piece.submap.middle().seq);
    if (node) piece.node = *node;
  }
  if (separator_ && cut_from_.size() == paths().size()) {
    const std::vector<std::size_t> first = begins();
    for (std::size_t i = 0; i < first.size(); ++i) cut_from_[i] = std::min(cut_from_[i], first[i]);
  }
}

std::optional<FleetEstimate> finished_before(const SeparatorPrior& separator,
                                             std::span<const VehiclePath> paths,
                                             const std::map<KeyframeId, KeyframePose>& keyframes,
                                             const FleetSettings& settings) {
  if (settings.solve == SolveWhat::kAll || separator.paths.size() != paths.size() ||
      !JointGraph::fits(separator, paths, settings.joint)) {
    return std::nullopt;
  }
  FleetEstimate done;
  done.groups.emplace_back();
  for (const VehiclePath& path : paths) {
    const auto known =
        std::find_if(separator.paths.begin(), separator.paths.end(),
                     [&](const SeparatorPath& b) { return b.stream == stream_of(path); });
    const std::size_t begin = *path.index_of(known->node);
    VehicleFrame frame;
    frame.vehicle = path.vehicle();
    frame.epoch = path.epoch();
    frame.T_map_odom = known->T_map_body * path.nodes()[begin].step->T_odom_body.inverse();
    bool first = true;
    for (std::size_t k = 0; k < begin; ++k) {
      const Increment& step = *path.nodes()[k].step;
      if (!step.keyframe) continue;
      const KeyframeId id{path.vehicle(), *step.keyframe};
      const auto pose = keyframes.find(id);
      if (pose == keyframes.end()) return std::nullopt;
      done.keyframes.insert(*pose);
      done.keyframes[id].t = path.nodes()[k].t;
      if (std::exchange(first, false)) {
        frame.T_map_odom = pose->second.T_map_body * step.T_odom_body.inverse();
      }
    }
    done.frames.push_back(std::move(frame));
    done.groups[0].push_back(path.vehicle());
  }
  return done;
}

bool RoundCentre::take_over(const SeparatorPrior& separator,
                            const std::map<KeyframeId, KeyframePose>& keyframes) {
  auto done = finished_before(separator, paths(), keyframes, centre_.settings());
  if (!done) return false;
  done_ = std::move(*done);
  last_ = done_;
  if (separator_) history_.push(std::move(*separator_));
  history_.keep_true(paths(), done_, separator.until, centre_.settings().separator.moved_m);
  separator_ = separator;
  return true;
}

void RoundCentre::forget_finished_points() { centre_.forget_points_before(cut_from_); }

}  // namespace rali::fleet
