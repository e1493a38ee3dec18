#include "rali/graph/local_graph.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "rali/base/assert.hpp"
#include "rali/graph/marginalise.hpp"
#include "rali/graph/root.hpp"

namespace rali::graph {

namespace {

bool finite(const geometry::SE3& T) { return T.R.allFinite() && T.p.allFinite(); }

bool finite(const KeyframeState& x) {
  return finite(x.T_odom_body) && x.v_odom_mps.allFinite() && x.gyro_bias_radps.allFinite() &&
         x.accel_bias_mps2.allFinite();
}

bool positive(double sigma) { return std::isfinite(sigma) && sigma > 0.0; }

bool finite(const InertialFactor& f) {
  return f.dR.allFinite() && f.dv_mps.allFinite() && f.dp_m.allFinite() &&
         f.gyro_bias_radps.allFinite() && f.accel_bias_mps2.allFinite() &&
         f.d_rotation_d_gyro.allFinite() && f.d_velocity_d_gyro.allFinite() &&
         f.d_velocity_d_accel.allFinite() && f.d_position_d_gyro.allFinite() &&
         f.d_position_d_accel.allFinite() && f.g_odom_mps2.allFinite() && finite(f.T_body_imu);
}

std::vector<int> range_of_columns(int first, int count) {
  std::vector<int> columns;
  for (int c = 0; c < count; ++c) columns.push_back(first + c);
  return columns;
}

InertialTerm with_root(const InertialFactor& f) {
  RALI_ASSERT(finite(f));
  RALI_ASSERT(positive(f.duration_s) && positive(f.gyro_walk_radps_rts) &&
              positive(f.accel_walk_mps2_rts));
  return {f, covariance_root(f.covariance)};
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

void LocalGraph::add_global(GlobalId id, const geometry::Vec3& mean,
                            const geometry::Mat3& information) {
  RALI_ASSERT(window_.find(id) < 0);
  RALI_ASSERT(mean.allFinite() && information.allFinite());
  GlobalNode node;
  node.id = id;
  node.value = mean;
  node.prior_mean = mean;
  node.prior_information = information;
  const auto place =
      std::lower_bound(window_.globals.begin(), window_.globals.end(), id,
                       [](const GlobalNode& global, GlobalId other) { return global.id < other; });
  window_.globals.insert(place, node);
  changed();
}

void LocalGraph::add_landmark(int number, const geometry::Vec3& p_odom_m,
                              const geometry::Mat3& covariance) {
  const Eigen::MatrixXd root = covariance_root(covariance);
  add_global(landmark_id(number), p_odom_m, root.transpose() * root);
}

void LocalGraph::add_bias(int number, double mean_m, double sigma_m) {
  RALI_ASSERT(positive(sigma_m));
  add_global(bias_id(number), {mean_m, 0.0, 0.0},
             geometry::Vec3(1.0 / (sigma_m * sigma_m), 0.0, 0.0).asDiagonal());
}

void LocalGraph::add_tau(int number, double mean_s, double sigma_s) {
  RALI_ASSERT(positive(sigma_s));
  add_global(tau_id(number), {mean_s, 0.0, 0.0},
             geometry::Vec3(1.0 / (sigma_s * sigma_s), 0.0, 0.0).asDiagonal());
}

void LocalGraph::add(const InertialFactor& factor) {
  RALI_ASSERT(contains(factor.i) && contains(factor.j) && factor.i < factor.j);
  RALI_ASSERT(std::none_of(window_.inertial.begin(), window_.inertial.end(), [&](const auto& term) {
    return term.f.i == factor.i && term.f.j == factor.j;
  }));
  window_.inertial.push_back(with_root(factor));
  changed();
}

void LocalGraph::replace(const InertialFactor& factor) {
  const auto old =
      std::find_if(window_.inertial.begin(), window_.inertial.end(),
                   [&](const auto& term) { return term.f.i == factor.i && term.f.j == factor.j; });
  RALI_ASSERT(old != window_.inertial.end());
  *old = with_root(factor);
  changed();
}

void LocalGraph::add(const RelativePoseFactor& factor) {
  RALI_ASSERT(contains(factor.i) && contains(factor.j) && factor.i != factor.j);
  RALI_ASSERT(finite(factor.T_i_j));
  window_.relative.push_back({factor, information_root(factor.information)});
  changed();
}

void LocalGraph::check(const RangeFactor& f) const {
  RALI_ASSERT(!contains_range(f.id));  // one measurement, one use
  RALI_ASSERT(contains(f.i) && (!f.j || (contains(*f.j) && *f.j != f.i)));
  RALI_ASSERT(f.alpha >= 0.0 && f.alpha <= 1.0 && (f.j || f.alpha == 0.0));
  RALI_ASSERT(!f.landmark || contains(landmark_id(*f.landmark)));
  RALI_ASSERT(!f.bias || contains(bias_id(*f.bias)));
  RALI_ASSERT(!f.tau || contains(tau_id(*f.tau)));
  RALI_ASSERT(f.p_i_m.allFinite() && f.p_j_m.allFinite() && f.p_fixed_odom_m.allFinite());
  RALI_ASSERT(!f.range_rate_mps || std::isfinite(*f.range_rate_mps));
  RALI_ASSERT(std::isfinite(f.range_m) && positive(f.sigma_m));
  RALI_ASSERT(std::isfinite(f.weight) && f.weight >= 0.0);
  // Older ones are not remembered: they could come twice unseen.
  RALI_ASSERT(f.t >= window_.keyframes.front().t - Duration::from_s(settings_.range_memory_s));
}

void LocalGraph::add(const RangeFactor& factor) {
  check(factor);
  used_ranges_.emplace(factor.id, factor.t);
  window_.ranges.push_back(factor);
  changed();
}

void LocalGraph::add(const StandstillFactor& factor) {
  RALI_ASSERT(contains(factor.i) && (!factor.next || contains(*factor.next)));
  RALI_ASSERT(positive(factor.sigma_mps) && positive(factor.sigma_m) && positive(factor.sigma_rad));
  window_.standstill.push_back(factor);
  changed();
}

void LocalGraph::add(const HeightFactor& factor) {
  RALI_ASSERT(contains(factor.i) && positive(factor.sigma_m));
  RALI_ASSERT(factor.n_odom.allFinite() && factor.q_odom_m.allFinite() &&
              std::isfinite(factor.h_m));
  window_.heights.push_back(factor);
  changed();
}

void LocalGraph::add(const PriorFactor& factor) {
  RALI_ASSERT(contains(factor.i) && finite(factor.mean));
  window_.priors.push_back({factor, information_root(factor.information)});
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
