#include "rali/graph/local_graph.hpp"

#include <algorithm>

#include "rali/base/assert.hpp"
#include "rali/graph/checks.hpp"
#include "rali/graph/global_marginals.hpp"
#include "rali/graph/marginalise.hpp"

namespace rali::graph {

namespace {

std::vector<int> range_of_columns(int first, int count) {
  std::vector<int> columns;
  for (int c = 0; c < count; ++c) columns.push_back(first + c);
  return columns;
}

}  // namespace

LocalGraph::LocalGraph(const LocalGraphSettings& settings) : settings_(settings) {}

void LocalGraph::add_keyframe(Seq seq, Time t, const KeyframeState& initial) {
  RALI_ASSERT(finite(initial));
  RALI_ASSERT(window_.keyframes.empty() ||
              (window_.keyframes.back().seq < seq && window_.keyframes.back().t < t));
  window_.keyframes.push_back({seq, t, initial});
  changed();
}

void LocalGraph::add_landmark(int number, const geometry::Vec3& p_odom_m,
                              const geometry::Mat3& covariance) {
  insert_landmark(window_, number, p_odom_m, covariance);
  changed();
}

void LocalGraph::add_bias(int number, double mean_m, double sigma_m) {
  insert_scalar(window_, bias_id(number), mean_m, sigma_m);
  changed();
}

void LocalGraph::add_tau(int number, double mean_s, double sigma_s) {
  insert_scalar(window_, tau_id(number), mean_s, sigma_s);
  changed();
}

void LocalGraph::add(const InertialFactor& factor) {
  RALI_ASSERT(factor.i < factor.j);
  RALI_ASSERT(std::none_of(window_.inertial.begin(), window_.inertial.end(), [&](const auto& term) {
    return term.f.i == factor.i && term.f.j == factor.j;
  }));
  window_.inertial.push_back(with_root(window_, factor));
  changed();
}

void LocalGraph::replace(const InertialFactor& factor) {
  const auto old =
      std::find_if(window_.inertial.begin(), window_.inertial.end(),
                   [&](const auto& term) { return term.f.i == factor.i && term.f.j == factor.j; });
  RALI_ASSERT(old != window_.inertial.end());
  *old = with_root(window_, factor);
  changed();
}

void LocalGraph::add(const RelativePoseFactor& factor) {
  window_.relative.push_back(with_root(window_, factor));
  changed();
}

void LocalGraph::add(const RangeFactor& factor) {
  RALI_ASSERT(!contains_range(factor.id));  // one measurement, one use
  check(window_, factor);
  // Older ones are not remembered: they could come twice unseen.
  RALI_ASSERT(factor.t >= window_.keyframes.front().t - Duration::from_s(settings_.range_memory_s));
  used_ranges_.emplace(factor.id, factor.t);
  window_.ranges.push_back(factor);
  changed();
}

void LocalGraph::add(const StandstillFactor& factor) {
  check(window_, factor);
  window_.standstill.push_back(factor);
  changed();
}

void LocalGraph::add(const HeightFactor& factor) {
  check(window_, factor);
  window_.heights.push_back(factor);
  changed();
}

void LocalGraph::add(const PriorFactor& factor) {
  window_.priors.push_back(with_root(window_, factor));
  changed();
}

bool LocalGraph::remove_range(std::uint64_t id) {
  changed();
  return std::erase_if(window_.ranges, [id](const RangeFactor& f) { return f.id == id; }) > 0;
}

void LocalGraph::relax(GlobalId id, double variance) {
  graph::relax(window_, id, variance);
  changed();
}

void LocalGraph::retire(GlobalId id) {
  const int g = window_.find(id);
  RALI_ASSERT(g >= 0);
  window_.globals[static_cast<std::size_t>(g)].retired = true;
}

void LocalGraph::marginalise_oldest() {
  graph::marginalise_oldest(window_, settings_.huber_sd);
  const Time forgotten = window_.keyframes.front().t - Duration::from_s(settings_.range_memory_s);
  std::erase_if(used_ranges_, [forgotten](const auto& used) { return used.second < forgotten; });
  changed();
}

SolveReport LocalGraph::solve(int iterations_max) {
  changed();
  return graph::solve(window_, settings_, iterations_max);
}

const KeyframeState& LocalGraph::state(Seq seq) const {
  const int k = window_.find(seq);
  RALI_ASSERT(k >= 0);
  return window_.keyframes[static_cast<std::size_t>(k)].x;
}

double LocalGraph::cost() const { return total_cost(window_, settings_.huber_sd); }

const Marginals& LocalGraph::marginals() {
  if (!marginals_) marginals_ = std::make_unique<Marginals>(window_, settings_.huber_sd);
  return *marginals_;
}

geometry::Mat6 LocalGraph::covariance(Seq seq) {
  return marginals().covariance(range_of_columns(window_.column(seq), 6));
}

std::vector<geometry::Mat6> LocalGraph::covariances() const {
  GlobalMarginals marginals(window_, settings_.huber_sd);
  std::vector<geometry::Mat6> all;
  for (const KeyframeNode& node : window_.keyframes) {
    all.emplace_back(marginals.own(window_.column(node.seq)).topLeftCorner<kPoseDim, kPoseDim>());
  }
  return all;
}

StateMat LocalGraph::newest_covariance() {
  RALI_ASSERT(!window_.keyframes.empty());
  const int first = window_.column(window_.keyframes.back().seq);
  return marginals().covariance(range_of_columns(first, kStateDim));
}

LandmarkEstimate LocalGraph::landmark(int number) {
  const GlobalId id = landmark_id(number);
  const int column = window_.column(id);
  return {window_.globals[static_cast<std::size_t>(window_.find(id))].value,
          marginals().covariance(range_of_columns(column, 3))};
}

ScalarEstimate LocalGraph::scalar(GlobalId id) {
  const int column = window_.column(id);
  return {window_.globals[static_cast<std::size_t>(window_.find(id))].value.x(),
          marginals().covariance({column})(0, 0)};
}

ScalarEstimate LocalGraph::bias(int number) { return scalar(bias_id(number)); }

ScalarEstimate LocalGraph::tau(int number) { return scalar(tau_id(number)); }

double LocalGraph::residual(const RangeFactor& factor) const {
  LinearFactor row;
  range_residual(window_, factor, row);
  return row.r(0);
}

RangePrediction LocalGraph::predict(const RangeFactor& factor) {
  return graph::predict(window_, marginals(), factor);
}

std::optional<RangeNis> LocalGraph::largest_nis_range() {
  const std::vector<RangeNis> all = range_nis(window_, marginals(), settings_.huber_sd);
  const auto worst = std::max_element(
      all.begin(), all.end(), [](const RangeNis& a, const RangeNis& b) { return a.nis < b.nis; });
  return worst == all.end() ? std::nullopt : std::optional(*worst);
}

}  // namespace rali::graph
