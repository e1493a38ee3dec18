#include <algorithm>
#include <cmath>
#include <map>

#include "rali/fleet/centre/joint_graph.hpp"
#include "rali/ranging/excess_watch.hpp"
#include "rali/ranging/path_fit.hpp"
#include "rali/ranging/range_thinning.hpp"
#include "rali/ranging/sight_turn.hpp"

namespace rali::fleet {

using geometry::Mat3;
using geometry::SE3;
using geometry::Vec3;

namespace {

/// While both ends are at standstill, or within the correlation time of the slowly varying error,
/// all ranges of a pair share one error.
class Stretches {
 public:
  explicit Stretches(double slow_time_s) : slow_time_s_(slow_time_s) {}

  /// Number of the stretch of the pair's next range; ranges come by time.
  std::size_t number_of(const JointRange& r) {
    const bool at_rest = r.a.at_rest && r.b.at_rest;
    const auto [known, is_new] = last_.try_emplace(r.pair);
    Stretch& last = known->second;
    const bool same = !is_new && last.at_rest == at_rest && last.blocked == r.blocked &&
                      (at_rest || (r.t - last.begin).s() < slow_time_s_);
    if (!same) last = {count_++, r.t, at_rest, r.blocked};
    return last.number;
  }

  [[nodiscard]] std::size_t count() const { return count_; }

 private:
  struct Stretch {
    std::size_t number = 0;
    Time begin;
    bool at_rest = false, blocked = false;
  };

  double slow_time_s_;
  std::map<int, Stretch> last_;  ///< by pair
  std::size_t count_ = 0;
};

/// Which ranges are longer than the line of sight, by the ranges of the same pair around them and
/// the motion of both odometries.
class Excess {
 public:
  Excess(const ranging::ExcessSettings& settings, double path_sigma_m)
      : settings_(settings), path_sigma_m_(path_sigma_m) {}

  /// Ranges come by time. @param between vector between the antennas by the odometries
  /// @param R_a, R_b from the odom of each end to the frame of `between`
  bool is_one(const JointRange& r, const Vec3& between, const Mat3& R_a, const Mat3& R_b) {
    if (!settings_.use) return false;
    Pair& pair = pairs_.try_emplace(r.pair, settings_).first->second;
    const Vec3 sight = between.normalized();
    const Vec3 turned = pair.sight_turn.add(r.t, sight);
    ranging::ExcessSample sample;
    sample.t = r.t;
    sample.range_m = r.range_m;
    sample.sigma_m = r.sigma_m;
    sample.speed_sigma_mps = std::hypot(r.a.speed_sigma_mps, r.b.speed_sigma_mps);
    sample.turn_sigma_m = turned.norm() * path_sigma_m_;
    if (pair.last) {
      sample.change_m = sight.dot(R_b * moved(pair.last->b, r.b, pair.last->t, r.t) -
                                  R_a * moved(pair.last->a, r.a, pair.last->t, r.t));
    }
    pair.last = r;
    // One that only may begin a step is left to the gate.
    return pair.watch.look(sample) == ranging::ExcessVerdict::kExcess;
  }

 private:
  struct Pair {
    explicit Pair(const ranging::ExcessSettings& settings) : watch(settings) {}

    ranging::ExcessWatch watch;
    ranging::SightTurn sight_turn;
    std::optional<JointRange> last;
  };

  /// In odom, of the antenna. By the speed: corrections of the pose, by other ranges, are no
  /// motion.
  static Vec3 moved(const RangeEnd& before, const RangeEnd& now, Time t_before, Time t) {
    const Vec3 lever = now.p_odom_m - now.place.T_odom_body.p;
    const Vec3 lever_before = before.p_odom_m - before.place.T_odom_body.p;
    const double dt_s = seconds_between(t_before, t);
    if (!now.v_odom_mps || !before.v_odom_mps || dt_s > ranging::kSteadySpeed_s)
      return now.p_odom_m - before.p_odom_m;
    return 0.5 * dt_s * (*now.v_odom_mps + *before.v_odom_mps) + lever - lever_before;
  }

  ranging::ExcessSettings settings_;
  double path_sigma_m_;
  std::map<int, Pair> pairs_;
};

}  // namespace

graph::RangeEnd JointGraph::end_of(std::size_t path, const RangeEnd& end) const {
  const auto& nodes = paths_[path].nodes();
  graph::RangeEnd factor;
  const std::size_t k = end.place.node;
  factor.i = seq(path, k);
  factor.p_i_m = nodes[k].step->T_odom_body.inverse() * end.p_odom_m;
  if (k + 1 < nodes.size() && end.place.alpha > 0.0) {
    factor.j = seq(path, k + 1);
    factor.p_j_m = nodes[k + 1].step->T_odom_body.inverse() * end.p_odom_m;
    factor.alpha = end.place.alpha;
  }
  return factor;
}

/// From the nodes before and after.
Vec3 JointGraph::velocity_map(std::size_t path, const RangeEnd& end) const {
  const auto& nodes = paths_[path].nodes();
  const std::size_t k = end.place.node;
  if (k + 1 >= nodes.size() || end.at_rest) return Vec3::Zero();
  const double span_s = (nodes[k + 1].t - nodes[k].t).s();
  const Vec3 step_m = nodes[k + 1].step->T_odom_body.p - nodes[k].step->T_odom_body.p;
  return T_map_odom_[path]->R * (step_m / span_s);
}

void JointGraph::add(const JointRanges& joint, const std::vector<std::optional<double>>& bias_m) {
  pairs_ = joint.pairs;
  if (before_ != nullptr) add_pairs_before();
  const auto in_group = [&](const AntennaPair& pair) {
    return T_map_odom_[pair.a.path] && T_map_odom_[pair.b.path];
  };
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    if (!settings_.bias || !in_group(pairs_[k])) continue;
    // For a pair with ranges only before the separator, the separator prior contains the bias.
    const std::optional<double> known_m = k < bias_m.size() ? bias_m[k] : std::nullopt;
    graph_->add_bias(static_cast<int>(k), known_m.value_or(0.0),
                     ranging::bias_sigma_m(ranging_.bias, known_m.has_value()));
  }
  graph_->add_tau(0, 0.0, ranging_.bias.tau_sigma_s);
  if (before_ != nullptr) take_separator_prior();
  // The error due to a wall is common to all ranges through it, and is nearly all of their error.
  ranging::SlowErrorSettings through_walls = ranging_.slow;
  through_walls.slow_sigma_m = ranging_.sight.sigma_factor * ranging_.limits.sigma_m;
  std::map<std::pair<int, bool>, ranging::RangeThinning> thinning;
  Stretches stretches(ranging_.slow.slow_time_s);
  Excess excess(ranging_.excess, settings_.path_sigma_m);
  for (const JointRange& r : joint.ranges) {
    const AntennaPair& pair = pairs_[static_cast<std::size_t>(r.pair)];
    if (!in_group(pair)) continue;
    const auto watch =
        thinning.try_emplace({r.pair, r.blocked}, r.blocked ? through_walls : ranging_.slow).first;
    const Vec3 between =
        *T_map_odom_[pair.b.path] * r.b.p_odom_m - *T_map_odom_[pair.a.path] * r.a.p_odom_m;
    const bool is_excess =
        excess.is_one(r, between, T_map_odom_[pair.a.path]->R, T_map_odom_[pair.b.path]->R);
    const double inflation = watch->second.inflation(r.t, r.sigma_m, r.a.at_rest && r.b.at_rest);
    const bool finished =
        r.a.place.node < begin_[pair.a.path] || r.b.place.node < begin_[pair.b.path];
    if (finished) continue;
    Range range;
    range.sigma_m = r.sigma_m;
    range.pair = static_cast<std::size_t>(r.pair);
    range.stretch = stretches.number_of(r);
    graph::RangeFactor& f = range.factor;
    static_cast<graph::RangeEnd&>(f) = end_of(pair.a.path, r.a);
    f.other = end_of(pair.b.path, r.b);
    f.id = next_range_++;
    f.t = r.t;
    if (settings_.bias) f.bias = r.pair;
    f.tau = 0;
    f.range_rate_mps =
        between.normalized().dot(velocity_map(pair.b.path, r.b) - velocity_map(pair.a.path, r.a));
    f.range_m = r.range_m;
    f.sigma_m = r.sigma_m * std::sqrt(inflation);
    range.excess = is_excess;
    range.used = !is_excess;
    if (range.used) graph_->add(f);
    ranges_.push_back(range);
  }
  stretches_ = stretches.count();
}

/// Classifies each range again with the current paths: a range rejected with wrong paths may fit
/// the right ones, and vice versa. One with an excess is never used: a path solved with it may fit.
void JointGraph::reclassify_outliers() {
  for (Range& range : ranges_) {
    if (range.excess) continue;
    const double nu_m = -graph_->residual(range.factor);
    const bool fits =
        ranging::fits_path(nu_m, range.sigma_m, settings_.path_sigma_m, ranging_.gate);
    if (fits == range.used) continue;
    if (fits) {
      range.factor.id = next_range_++;
      graph_->add(range.factor);
    } else {
      graph_->remove_range(range.factor.id);
    }
    range.used = fits;
  }
  weigh_stretches();
}

/// Ranges with a common error have little weight each, so neither gate nor loss detects that all
/// together are off by many sigma: e.g. a person between two vehicles at standstill. Their mean is
/// tested as one measurement. A range that is too long may have any error, so its weight falls with
/// the square of the deviation; for one too short only linearly.
void JointGraph::weigh_stretches() {
  if (settings_.stretch_sd <= 0.0) return;

  struct Sum {
    double information = 0.0, residual = 0.0;  ///< weighted
  };

  std::vector<Sum> sums(stretches_);
  for (const Range& range : ranges_) {
    if (!range.used) continue;
    const double weight = 1.0 / (range.factor.sigma_m * range.factor.sigma_m);
    sums[range.stretch].information += weight;
    sums[range.stretch].residual += weight * graph_->residual(range.factor);
  }
  std::vector<std::pair<std::uint64_t, double>> sigma_m;
  for (Range& range : ranges_) {
    const Sum& sum = sums[range.stretch];
    if (!range.used || !(sum.information > 0.0)) continue;
    // Predicted minus measured, in sigma of the mean.
    const double off = sum.residual / std::sqrt(sum.information) / settings_.stretch_sd;
    range.uncertainty = off < -1.0 ? -off : std::sqrt(std::max(1.0, off));
    sigma_m.emplace_back(range.factor.id, range.uncertainty * range.factor.sigma_m);
  }
  std::sort(sigma_m.begin(), sigma_m.end());
  graph_->set_range_sigmas(sigma_m);
}

std::vector<PairBias> JointGraph::biases() {
  std::vector<PairBias> biases(pairs_.size());
  std::vector<double> squares(pairs_.size(), 0.0);
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    biases[k].a = paths_[pairs_[k].a.path].vehicle();
    biases[k].b = paths_[pairs_[k].b.path].vehicle();
    biases[k].antenna_a = pairs_[k].a.number;
    biases[k].antenna_b = pairs_[k].b.number;
    if (!T_map_odom_[pairs_[k].a.path] || !T_map_odom_[pairs_[k].b.path]) continue;
    if (!settings_.bias) continue;
    const graph::ScalarEstimate bias = graph_->bias(static_cast<int>(k));
    biases[k].bias_m = bias.mean;
    biases[k].sigma_m = std::sqrt(std::max(0.0, bias.variance));
    if (const SeparatorBias* known = known_before(k)) {
      biases[k].ranges = known->ranges;
      biases[k].used = known->used;
      squares[k] = known->squares_m2;
    }
  }
  for (const Range& range : ranges_) {
    const std::size_t k = range.pair;
    ++biases[k].ranges;
    if (!range.used) continue;
    ++biases[k].used;
    const double r_m = graph_->residual(range.factor);
    squares[k] += r_m * r_m;
  }
  for (std::size_t k = 0; k < biases.size(); ++k) {
    if (biases[k].used == 0) continue;
    biases[k].residual_std_m = std::sqrt(squares[k] / static_cast<double>(biases[k].used));
  }
  std::erase_if(biases, [](const PairBias& bias) { return bias.ranges == 0; });
  return biases;
}

std::vector<UsedRange> JointGraph::used_ranges() {
  std::vector<UsedRange> out;
  for (const Range& range : ranges_) {
    if (!range.used) continue;
    const AntennaPair& pair = pairs_[range.pair];
    const auto a = keyframe_near(pair.a.path, range.factor);
    const auto b = keyframe_near(pair.b.path, *range.factor.other);
    if (!a || !b) continue;
    const auto antenna = [&](const Antenna& end, std::size_t node) {
      return Vec3(T_map_body(end.path, node) * paths_[end.path].antennas_body_m()[end.number]);
    };
    UsedRange used;
    used.t = range.factor.t;
    used.a = {paths_[pair.a.path].vehicle(), *paths_[pair.a.path].nodes()[*a].step->keyframe};
    used.b = {paths_[pair.b.path].vehicle(), *paths_[pair.b.path].nodes()[*b].step->keyframe};
    // The range as it would be between the keyframes, with its own residual kept.
    used.range_m =
        (antenna(pair.a, *a) - antenna(pair.b, *b)).norm() - graph_->residual(range.factor);
    used.sigma_m = range.uncertainty * range.factor.sigma_m;
    out.push_back(used);
  }
  return out;
}

/// The keyframe nearest in time to the node before an end; nothing if the path has none.
std::optional<std::size_t> JointGraph::keyframe_near(std::size_t path,
                                                     const graph::RangeEnd& end) const {
  const auto& nodes = paths_[path].nodes();
  const std::size_t at = path_node(end.i).node;
  for (std::size_t off = 0; off < nodes.size(); ++off) {
    if (off <= at - begin_[path] && nodes[at - off].step->keyframe) return at - off;
    if (at + off < nodes.size() && nodes[at + off].step->keyframe) return at + off;
  }
  return std::nullopt;
}

}  // namespace rali::fleet
