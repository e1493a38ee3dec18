#include <algorithm>
#include <cmath>
#include <map>

#include "rali/fleet/path/shape.hpp"
#include "rali/ranging/second_look.hpp"
#include "rali/vehicle/back_end.hpp"

namespace rali::vehicle {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;
using graph::LocalGraph;
using graph::Seq;

namespace {

Seq seq_of(std::size_t k) { return static_cast<Seq>(k); }

}  // namespace

void BackEnd::finish(const std::vector<PlaceRecord>& places, const std::vector<PairRecord>& pairs,
                     const Vec3& g_odom_mps2, OutputList& out) {
  const bool ranged =
      std::any_of(ranges_.begin(), ranges_.end(), [](const NodeRange& r) { return r.record.used; });
  const bool far = blind_m_ > settings_.back_end.blind_min_m;
  if (far && ranged && nodes_.size() > 2) {
    const std::unique_ptr<LocalGraph> graph = build(places, pairs, g_odom_mps2);
    for (int round = 0; round < settings_.back_end.rounds; ++round) {
      graph->solve(settings_.back_end.iterations);
      if (round + 1 < settings_.back_end.rounds) judge_again(*graph, pairs);
    }
    tell(*graph, out);
  }
  forget();
}

std::unique_ptr<LocalGraph> BackEnd::build(const std::vector<PlaceRecord>& places,
                                           const std::vector<PairRecord>& pairs,
                                           const Vec3& g_odom_mps2) const {
  graph::LocalGraphSettings settings = settings_.back_end.graph;
  settings.range_memory_s = 1e6;
  auto graph = std::make_unique<LocalGraph>(settings);
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    const fleet::Increment& step = nodes_[k].step;
    graph->add_keyframe(
        seq_of(k), nodes_[k].t,
        {step.T_odom_body, step.v_odom_mps, step.gyro_bias_radps, step.accel_bias_mps2});
    add_motion(*graph, k, g_odom_mps2);
  }
  for (const PlaceRecord& p : places) {
    graph->add_landmark(p.place, p.p_odom_m, p.prior_covariance_m2);
  }
  for (const PairRecord& p : pairs) graph->add_bias(p.pair, p.bias_m, p.bias_sigma_m);
  graph->add_tau(0, 0.0, settings_.ranging.bias.tau_sigma_s);
  for (const NodeRange& r : ranges_) {
    if (r.record.used) graph->add(factor_of(r));
  }
  return graph;
}

/// What ties node k to the one before; the first is where the filter had it.
void BackEnd::add_motion(LocalGraph& graph, std::size_t k, const Vec3& g_odom_mps2) const {
  const BackEndSettings& s = settings_.back_end;
  const fleet::Increment& node = nodes_[k].step;
  if (k == 0) {
    graph::PriorFactor prior;
    prior.i = seq_of(k);
    prior.mean = graph.state(prior.i);
    const auto set = [&prior](int first, double sigma) {
      prior.information.diagonal().segment<3>(first).setConstant(1.0 / (sigma * sigma));
    };
    set(graph::kTheta, s.shape.shape_rad);
    set(graph::kPos, s.shape.shape_m);
    set(graph::kVel, s.start_speed_sigma_mps);
    set(graph::kGyroBias, s.start_gyro_bias_sigma_radps);
    set(graph::kAccelBias, s.start_accel_bias_sigma_mps2);
    graph.add(prior);
    return;
  }
  const fleet::Increment& before = nodes_[k - 1].step;
  graph::RelativePoseFactor shape;
  shape.i = seq_of(k - 1);
  shape.j = seq_of(k);
  shape.T_i_j = before.T_odom_body.inverse() * node.T_odom_body;
  shape.information = fleet::shape_information(node.lidar_information, before.T_odom_body, s.shape);
  if (!node.inertial) {
    // Nothing else bridges a gap in the inertial data: the filter's step, loosely.
    fleet::loosen_gap(shape.information, s.shape);
  }
  graph.add(shape);
  if (node.inertial) {
    graph::InertialFactor f = *node.inertial;
    f.i = shape.i;
    f.j = shape.j;
    f.g_odom_mps2 = g_odom_mps2;
    graph.add(f);
  }
  if (!before.at_rest) return;
  graph::StandstillFactor rest;
  rest.i = shape.i;
  if (node.at_rest) rest.next = shape.j;
  graph.add(rest);
}

graph::RangeFactor BackEnd::factor_of(const NodeRange& range) const {
  const RangeRecord& r = range.record;
  graph::RangeFactor f;
  f.id = r.id;
  f.t = r.t;
  const PathNode& i = nodes_[range.after];
  const Vec3 p_odom = r.T_odom_body * r.p_body_antenna_m;
  f.i = seq_of(range.after);
  f.p_i_m = i.step.T_odom_body.inverse() * p_odom;
  if (range.after + 1 < nodes_.size()) {
    const PathNode& j = nodes_[range.after + 1];
    f.j = seq_of(range.after + 1);
    f.p_j_m = j.step.T_odom_body.inverse() * p_odom;
    const double span_s = (j.t - i.t).s();
    f.alpha = span_s > 0.0 ? std::clamp((r.t - i.t).s() / span_s, 0.0, 1.0) : 0.0;
  }
  f.landmark = r.place;
  f.bias = r.pair;
  f.tau = 0;
  f.range_rate_mps = r.rate_mps;
  f.range_m = r.range_m;
  f.sigma_m = std::sqrt(r.R_m2);
  return f;
}

/// Each range once more against the path as it is known now, in the order of time: what did not fit
/// a wrong path may fit the right one, and the other way round.
void BackEnd::judge_again(LocalGraph& graph, const std::vector<PairRecord>& pairs) {
  const ranging::RangingSettings& r = settings_.ranging;
  std::map<int, ranging::ExcessWatch> watches;
  for (const PairRecord& p : pairs) watches.emplace(p.pair, ranging::ExcessWatch(r.excess));
  std::stable_sort(ranges_.begin(), ranges_.end(),
                   [](const NodeRange& a, const NodeRange& b) { return a.record.t < b.record.t; });
  const double path_sigma_m = settings_.back_end.path_sigma_m;
  for (NodeRange& range : ranges_) {
    RangeRecord& record = range.record;
    const graph::RangeFactor factor = factor_of(range);
    const double nu_m = -graph.residual(factor);
    const bool fits = ranging::fits_path(watches.at(record.pair), record.t, nu_m, record.sigma_m,
                                         path_sigma_m, r.gate);
    if (fits == record.used) continue;
    if (fits && !graph.contains_range(record.id)) {
      graph.add(factor);
      record.used = true;
    } else if (!fits) {
      graph.remove_range(record.id);
      record.used = false;
    }
  }
}

/// Keyframes as the graph has them. What the map itself is wrong by the graph does not know: it is
/// taken from the filter, where the LiDAR sees.
void BackEnd::tell(const LocalGraph& graph, OutputList& out) const {
  const std::vector<Mat6> covariances = graph.covariances();
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    const fleet::Increment& node = nodes_[k].step;
    if (!node.keyframe) continue;
    KeyframeCorrected corrected;
    corrected.id = {self_, *node.keyframe};
    corrected.t = nodes_[k].t;
    corrected.T_local_body = graph.state(seq_of(k)).T_odom_body;
    const Mat6 share = fleet::known_share(node.lidar_information, settings_.back_end.shape);
    corrected.covariance = covariances[k] + share * node.covariance * share.transpose();
    out.emplace_back(corrected);
  }
}

}  // namespace rali::vehicle
