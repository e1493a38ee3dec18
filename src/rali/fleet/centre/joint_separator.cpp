#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include <Eigen/Eigenvalues>

#include "rali/base/assert.hpp"
#include "rali/fleet/centre/joint_graph.hpp"
#include "rali/fleet/centre/path_frames.hpp"
#include "rali/graph/checks.hpp"

namespace rali::fleet {

using graph::Seq;

namespace {

/// Positive semidefinite up to rounding; each unknown scaled by its own sigma.
bool is_information(const Eigen::MatrixXd& H) {
  constexpr double kRounding = 1e-6;
  if (!H.allFinite() || !(H.diagonal().array() >= 0.0).all()) return false;
  if (H.size() == 0) return true;
  const Eigen::VectorXd scale =
      H.diagonal().unaryExpr([](double d) { return d > 0.0 ? 1.0 / std::sqrt(d) : 0.0; });
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      Eigen::MatrixXd(scale.asDiagonal() * H * scale.asDiagonal()), Eigen::EigenvaluesOnly);
  return eigen.info() == Eigen::Success && eigen.eigenvalues().minCoeff() >= -kRounding;
}

bool has_antenna(std::span<const VehiclePath> paths, VehicleId vehicle, std::uint8_t antenna) {
  return std::any_of(paths.begin(), paths.end(), [&](const VehiclePath& path) {
    return path.vehicle() == vehicle && antenna < path.antennas_body_m().size();
  });
}

}  // namespace

bool JointGraph::fits(const SeparatorPrior& separator, std::span<const VehiclePath> paths,
                      const JointSettings& settings) {
  std::map<StreamKey, std::uint32_t> begins;
  for (const SeparatorPath& known : separator.paths) {
    const VehiclePath* path = path_of(paths, known.stream);
    if (path == nullptr || !path->index_of(known.node)) return false;
    if (!begins.emplace(known.stream, known.node).second) return false;
    if (!graph::finite(known.T_map_body)) return false;
  }
  std::set<std::pair<StreamKey, std::uint32_t>> seen;
  for (const SeparatorNode& known : separator.nodes) {
    const auto begin = begins.find(known.stream);
    if (begin == begins.end() || known.node < begin->second) return false;
    if (!path_of(paths, known.stream)->index_of(known.node)) return false;
    if (!seen.emplace(known.stream, known.node).second || !graph::finite(known.x)) return false;
  }
  std::set<std::tuple<VehicleId, std::uint8_t, VehicleId, std::uint8_t>> pairs;
  for (const SeparatorBias& known : separator.biases) {
    if (!has_antenna(paths, known.a, known.antenna_a)) return false;
    if (!has_antenna(paths, known.b, known.antenna_b) || known.a == known.b) return false;
    if (!pairs.emplace(known.a, known.antenna_a, known.b, known.antenna_b).second) return false;
    if (!std::isfinite(known.bias_m)) return false;
  }
  const Eigen::Index n = separator.unknowns();
  return (settings.bias || separator.biases.empty()) &&
         std::isfinite(separator.tau_s.value_or(0.0)) && separator.H.rows() == n &&
         separator.H.cols() == n && separator.b.size() == n && separator.b.allFinite() &&
         is_information(separator.H);
}

JointGraph::PathNode JointGraph::path_node(Seq seq) const {
  // Paths of other groups have no nodes: the last path that begins there is the right one.
  const auto after = std::upper_bound(first_.begin(), first_.end() - 1, std::size_t{seq});
  const auto path = static_cast<std::size_t>(after - first_.begin()) - 1;
  return {path, begin_[path] + seq - first_[path]};
}

/// A degenerate step needs more iterations than one constrained by the LiDAR.
bool JointGraph::any_degenerate() const {
  for (std::size_t path = 0; path < paths_.size(); ++path) {
    if (!T_map_odom_[path]) continue;
    const auto& nodes = paths_[path].nodes();
    const auto begin = nodes.begin() + static_cast<std::ptrdiff_t>(begin_[path]);
    if (std::any_of(begin, nodes.end(), [](const auto& n) { return n.step->degenerate; }))
      return true;
  }
  return false;
}

/// Pairs with ranges only in earlier rounds are kept: new ranges may follow.
void JointGraph::add_pairs_before() {
  for (const SeparatorBias& bias : before_->biases) {
    AntennaPair pair{{paths_.size(), bias.antenna_a}, {paths_.size(), bias.antenna_b}};
    for (std::size_t path = paths_.size(); path-- > 0;) {  // of several epochs the first, as ranges
      if (paths_[path].vehicle() == bias.a) pair.a.path = path;
      if (paths_[path].vehicle() == bias.b) pair.b.path = path;
    }
    if (std::find(pairs_.begin(), pairs_.end(), pair) == pairs_.end()) pairs_.push_back(pair);
  }
}

void JointGraph::take_separator_prior() {
  graph::DensePrior prior;
  for (const SeparatorNode& known : before_->nodes) {
    for (std::size_t path = 0; path < paths_.size(); ++path) {
      if (stream_of(paths_[path]) != known.stream) continue;
      const auto k = paths_[path].index_of(known.node);
      RALI_ASSERT(k && *k >= begin_[path]);  // checked before: fits()
      prior.keyframes.push_back({seq(path, *k), known.x});
    }
  }
  for (const SeparatorBias& known : before_->biases) {
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      if (known_before(k) != &known) continue;
      prior.globals.push_back({graph::bias_id(static_cast<int>(k)), {known.bias_m, 0.0, 0.0}});
    }
  }
  if (before_->tau_s) prior.globals.push_back({graph::tau_id(0), {*before_->tau_s, 0.0, 0.0}});
  prior.H = before_->H;
  prior.b = before_->b;
  graph_->set_separator_prior(std::move(prior));
  for (const SeparatorPath& known : before_->paths) {
    for (std::size_t path = 0; path < paths_.size(); ++path) {
      if (!known.holds_map || stream_of(paths_[path]) != known.stream) continue;
      graph_->set_pose(seq(path, begin_[path]), known.T_map_body);
      hold_map(seq(path, begin_[path]), known.T_map_body);
    }
  }
}

/// Ranges of earlier rounds, and those marginalised with their nodes.
void JointGraph::count_ranges(std::size_t pair, const graph::PoseGraph& left,
                              SeparatorBias& count) const {
  if (const SeparatorBias* known = known_before(pair)) {
    count.ranges = known->ranges;
    count.used = known->used;
    count.squares_m2 = known->squares_m2;
  }
  const auto is_left = [&left](const graph::RangeEnd& end) {
    return left.contains(end.i) && (!end.j || left.contains(*end.j));
  };
  for (const Range& range : ranges_) {
    if (range.pair != pair || (is_left(range.factor) && is_left(*range.factor.other))) continue;
    ++count.ranges;
    if (!range.used) continue;
    ++count.used;
    const double r_m = graph_->residual(range.factor);
    count.squares_m2 += r_m * r_m;
  }
}

const SeparatorBias* JointGraph::known_before(std::size_t pair) const {
  if (before_ == nullptr) return nullptr;
  const AntennaPair& p = pairs_[pair];
  for (const SeparatorBias& known : before_->biases) {
    if (paths_[p.a.path].vehicle() == known.a && p.a.number == known.antenna_a &&
        paths_[p.b.path].vehicle() == known.b && p.b.number == known.antenna_b) {
      return &known;
    }
  }
  return nullptr;
}

SeparatorPrior JointGraph::separator(Time until) {
  SeparatorPrior out;
  out.until = until;
  graph::PoseGraph left = *graph_;
  std::vector<Seq> leave;
  for (std::size_t path = 0; path < paths_.size(); ++path) {
    const auto& nodes = paths_[path].nodes();
    if (!T_map_odom_[path] || nodes.empty()) continue;
    std::size_t last = begin_[path];
    while (last + 1 < nodes.size() && nodes[last + 1].t <= until) {
      leave.push_back(seq(path, last));
      ++last;
    }
    const Seq at = seq(path, last);
    out.paths.push_back({stream_of(paths_[path]), nodes[last].step->node, graph_->pose(at),
                         graph_->covariance(at), holds_map_ == at});
  }
  left.marginalise(std::move(leave));
  const graph::DensePrior& prior = left.separator();
  for (const auto& block : prior.keyframes) {
    const PathNode at = path_node(block.seq);
    out.nodes.push_back({stream_of(paths_[at.path]), paths_[at.path].nodes()[at.node].step->node,
                         has_speed(block.seq), block.x_lin});
  }
  for (const auto& block : prior.globals) {
    if (block.id.kind == graph::GlobalKind::kTau) {
      out.tau_s = block.x_lin.x();
      continue;
    }
    const AntennaPair& pair = pairs_[static_cast<std::size_t>(block.id.number)];
    out.biases.push_back({paths_[pair.a.path].vehicle(), paths_[pair.b.path].vehicle(),
                          pair.a.number, pair.b.number, block.x_lin.x()});
    count_ranges(static_cast<std::size_t>(block.id.number), left, out.biases.back());
  }
  out.H = prior.H;
  out.b = prior.b;
  return out;
}

}  // namespace rali::fleet
