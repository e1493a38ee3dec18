#include "rali/graph/pose_graph.hpp"

#include <algorithm>
#include <cmath>

#include "rali/base/assert.hpp"
#include "rali/graph/checks.hpp"
#include "rali/graph/levenberg_marquardt.hpp"
#include "rali/graph/marginalise.hpp"
#include "rali/graph/rotation_start.hpp"

namespace rali::graph {

namespace {

constexpr double kUnitSlack = 1e-6;

}  // namespace

PoseGraph::PoseGraph(const GraphSettings& settings) : settings_(settings) {}

PoseGraph::PoseGraph(const PoseGraph& other)
    : settings_(other.settings_),
      window_(other.window_),
      next_(other.next_),
      used_ranges_(other.used_ranges_) {}

PoseGraph& PoseGraph::operator=(const PoseGraph& other) {
  if (this != &other) *this = PoseGraph(other);
  return *this;
}

const Window& PoseGraph::window() const {
  if (!laid_out_) window_.lay_out();
  laid_out_ = true;
  return window_;
}

Seq PoseGraph::add_node(const KeyframeState& x, int dim) {
  RALI_ASSERT(finite(x));
  KeyframeNode node;
  node.seq = next_++;
  node.x = x;
  node.dim = dim;
  window_.keyframes.push_back(node);
  laid_out_ = false;
  changed();
  return node.seq;
}

Seq PoseGraph::add_pose(const geometry::SE3& T_map_body) {
  KeyframeState x;
  x.T_odom_body = T_map_body;
  return add_node(x, kPoseDim);
}

Seq PoseGraph::add_state(const KeyframeState& initial) { return add_node(initial, kStateDim); }

void PoseGraph::add_landmark(int number, const geometry::Vec3& p_map_m,
                             const geometry::Mat3& covariance) {
  insert_landmark(window_, number, p_map_m, covariance);
  laid_out_ = false;
  changed();
}

void PoseGraph::add_bias(int number, double mean_m, double sigma_m) {
  insert_scalar(window_, bias_id(number), mean_m, sigma_m);
  laid_out_ = false;
  changed();
}

void PoseGraph::add_tau(int number, double mean_s, double sigma_s) {
  insert_scalar(window_, tau_id(number), mean_s, sigma_s);
  laid_out_ = false;
  changed();
}

KeyframeNode& PoseGraph::node(Seq seq) {
  const int k = window_.find(seq);
  RALI_ASSERT(k >= 0);
  return window_.keyframes[static_cast<std::size_t>(k)];
}

void PoseGraph::fix(Seq seq, bool fixed) {
  node(seq).fixed = fixed;
  laid_out_ = false;
  changed();
}

void PoseGraph::set_pose(Seq seq, const geometry::SE3& T_map_body) {
  RALI_ASSERT(finite(T_map_body));
  node(seq).x.T_odom_body = T_map_body;
  changed();
}

void PoseGraph::add(const InertialFactor& factor) {
  window_.inertial.push_back(with_root(window_, factor));
  changed();
}

void PoseGraph::add(const RelativePoseFactor& factor) {
  window_.relative.push_back(with_root(window_, factor));
  changed();
}

void PoseGraph::add(const RangeFactor& factor) {
  RALI_ASSERT(!contains_range(factor.id));  // each measurement is used once
  check(window_, factor);
  used_ranges_.insert(factor.id);
  window_.ranges.push_back(factor);
  changed();
}

void PoseGraph::add(const StandstillFactor& factor) {
  check(window_, factor);
  window_.standstill.push_back(factor);
  changed();
}

void PoseGraph::add(const GravityFactor& factor) {
  RALI_ASSERT(contains(factor.i) && positive(factor.sigma_rad));
  RALI_ASSERT(std::abs(factor.up_body.norm() - 1.0) < kUnitSlack);
  window_.gravity.push_back(factor);
  changed();
}

void PoseGraph::add(const PriorFactor& factor) {
  window_.priors.push_back(with_root(window_, factor));
  changed();
}

void PoseGraph::add_pose_prior(Seq seq, const geometry::SE3& mean,
                               const geometry::Mat6& information) {
  PriorFactor prior;
  prior.i = seq;
  prior.mean = state(seq);
  prior.mean.T_odom_body = mean;
  prior.information.topLeftCorner<kPoseDim, kPoseDim>() = information;
  add(prior);
}

void PoseGraph::add(const LoopFactor& factor) {
  RALI_ASSERT(!contains_loop(factor.id));
  LoopTerm loop;
  loop.id = factor.id;
  loop.term = with_root(window_, factor.pose);
  loop.dof = rank(loop.term);
  loop.weight = settings_.guard == LoopGuard::kNone ? 1.0 : 0.0;
  window_.loops.push_back(loop);
  changed();
}

bool PoseGraph::contains_loop(std::uint64_t id) const {
  return std::any_of(window_.loops.begin(), window_.loops.end(),
                     [id](const LoopTerm& loop) { return loop.id == id; });
}

bool PoseGraph::remove_range(std::uint64_t id) {
  changed();
  return std::erase_if(window_.ranges, [id](const RangeFactor& f) { return f.id == id; }) > 0;
}

void PoseGraph::set_range_sigmas(std::span<const std::pair<std::uint64_t, double>> sigma_m) {
  for (RangeFactor& f : window_.ranges) {
    const auto reported = std::lower_bound(sigma_m.begin(), sigma_m.end(), f.id,
                                           [](const std::pair<std::uint64_t, double>& entry,
                                              std::uint64_t id) { return entry.first < id; });
    if (reported != sigma_m.end() && reported->first == f.id) f.sigma_m = reported->second;
  }
  changed();
}

SolveReport PoseGraph::solve(int iterations_max) {
  changed();
  if (window().columns() == 0) return {};
  NormalEquations equations(window_, settings_.huber_sd);
  return levenberg_marquardt(window_, equations, settings_, stop_, iterations_max);
}

SolveReport PoseGraph::solve_full() {
  changed();
  if (window().columns() == 0) return {};
  return solve_with_guard(window_, settings_, stop_);
}

void PoseGraph::marginalise(std::vector<Seq> nodes) {
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  RALI_ASSERT(nodes.size() < window_.keyframes.size());
  graph::marginalise(window_, nodes, settings_.huber_sd);
  laid_out_ = false;
  changed();
}

void PoseGraph::set_separator_prior(DensePrior prior) {
  RALI_ASSERT(window_.dense.H.size() == 0);
  Eigen::Index size = 0;
  for (const DensePrior::KeyframeBlock& block : prior.keyframes) {
    KeyframeNode& of = node(block.seq);
    RALI_ASSERT(!of.fixed && finite(block.x_lin));
    of.x = block.x_lin;
    size += of.dim;
  }
  for (const DensePrior::GlobalBlock& block : prior.globals) {
    const int g = window_.find(block.id);
    RALI_ASSERT(g >= 0 && block.x_lin.allFinite());
    GlobalNode& global = window_.globals[static_cast<std::size_t>(g)];
    global.value = block.x_lin;
    global.prior_information.setZero();
    size += global.dim();
  }
  RALI_ASSERT(prior.H.rows() == size && prior.H.cols() == size && prior.b.size() == size);
  RALI_ASSERT(prior.H.allFinite() && prior.b.allFinite() && std::isfinite(prior.cost));
  window_.dense = std::move(prior);
  laid_out_ = false;
  changed();
}

std::vector<LoopState> PoseGraph::loops() const {
  std::vector<LoopState> states;
  for (const LoopTerm& loop : window_.loops) {
    states.push_back({loop.id, loop_chi2(window(), loop), loop.dof, loop.weight});
  }
  return states;
}

double PoseGraph::cost() const { return total_cost(window(), settings_.huber_sd); }

int PoseGraph::degrees_of_freedom() const { return graph::degrees_of_freedom(window()); }

}  // namespace rali::graph
