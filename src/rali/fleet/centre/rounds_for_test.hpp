#pragma once

// A fleet that drives along x in rounds, as facts: a vehicle at standstill is the anchor.

#include <algorithm>
#include <vector>

#include "rali/base/rng.hpp"
#include "rali/fleet/centre/centre.hpp"

namespace rali::fleet {

struct RoundsForTest {
  std::size_t vehicles = 3;
  int steps = 16;  ///< of half a metre and half a second, of each driving vehicle in a round
  double stand_s = 4.0;
  double step_sigma_m = 0.02;
  bool to_and_fro = false;  ///< every other round drives back
  bool degenerate = false;  ///< the LiDAR is degenerate along x, inertial data bridge it
};

/// Produces the facts of one round after the other.
class FleetForTest {
 public:
  explicit FleetForTest(const RoundsForTest& options)
      : o_(options), rng_(7, "rounds"), v_(options.vehicles) {
    for (std::size_t v = 0; v < v_.size(); ++v) {
      v_[v].p_m = start_m(v);
      EpochStart start;
      start.name = "v" + std::to_string(v + 1);
      start.antennas_body_m = {geometry::Vec3(0.0, 0.0, 0.5)};
      report(v, start);
      node(v, 0.0, true);
    }
  }

  [[nodiscard]] FleetKnowledge knowledge() const {
    FleetKnowledge known;
    for (std::size_t v = 1; v < v_.size(); ++v) {
      GivenStart start;
      start.relative_to = VehicleId{0};
      start.vehicle = id(v);
      start.T_relative_vehicle.p = start_m(v) - start_m(0);
      start.sigma_m = 0.05;
      start.sigma_rad = 0.01;
      known.starts.push_back(start);
    }
    return known;
  }

  /// All facts of the next round; all vehicles are at standstill at its end.
  std::vector<Fact> round() {
    out_.clear();
    stand();
    const std::size_t anchor = static_cast<std::size_t>(rounds_) % v_.size();
    const double step_m = o_.to_and_fro && rounds_ % 2 == 1 ? -0.5 : 0.5;
    for (int k = 0; k < o_.steps; ++k) {
      t_s_ += 0.5;
      for (std::size_t v = 0; v < v_.size(); ++v) {
        if (v == anchor) continue;
        const bool last = k + 1 == o_.steps;
        v_[v].p_m += geometry::Vec3(step_m, 0.0, 0.0);
        v_[v].error_m.x() += o_.step_sigma_m * rng_.normal();
        node(v, last ? 0.0 : step_m / 0.5, last);
      }
      ranges();
    }
    stand();
    ++rounds_;
    std::vector<Fact> facts = facts_of_start_;
    facts_of_start_.clear();
    facts.insert(facts.end(), out_.begin(), out_.end());
    return facts;
  }

  [[nodiscard]] Time now() const { return Time::from_s(t_s_); }

  [[nodiscard]] geometry::Vec3 p_m(std::size_t v) const { return v_[v].p_m; }

  static VehicleId id(std::size_t v) { return {static_cast<std::uint16_t>(v)}; }

 private:
  struct Vehicle {
    geometry::Vec3 p_m = geometry::Vec3::Zero();      ///< true position
    geometry::Vec3 error_m = geometry::Vec3::Zero();  ///< error of the odometry
    std::uint32_t nodes = 0, facts = 0;
    double speed_mps = 0.0, t_s = 0.0;
    geometry::Vec3 at_m = geometry::Vec3::Zero();  ///< true position at the last node
  };

  static geometry::Vec3 start_m(std::size_t v) {
    return {2.0 * static_cast<double>(v), v % 2 == 0 ? -1.0 * static_cast<double>(v) : 3.0, 0.0};
  }

  void report(std::size_t v, FactBody body) {
    const Fact fact{{id(v), 0, v_[v].facts++}, now(), std::move(body)};
    (rounds_ == 0 && out_.empty() && t_s_ == 0.0 ? facts_of_start_ : out_).push_back(fact);
  }

  [[nodiscard]] geometry::SE3 odom(std::size_t v) const {
    geometry::SE3 T;
    T.p = v_[v].p_m + v_[v].error_m - start_m(v);
    return T;
  }

  void node(std::size_t v, double speed_mps, bool at_rest) {
    Vehicle& of = v_[v];
    Increment step;
    step.node = of.nodes;
    step.keyframe = of.nodes;
    step.begins = of.nodes == 0;
    step.at_rest = at_rest;
    step.levelled = true;
    step.degenerate = o_.degenerate && !at_rest;
    step.T_odom_body = odom(v);
    step.v_odom_mps = {speed_mps, 0.0, 0.0};
    step.covariance = geometry::Mat6::Identity() * 1e-6;
    step.lidar_information = geometry::Mat6::Identity() * 1e6;
    if (step.degenerate) step.lidar_information(3, 3) = 0.0;
    if (of.nodes > 0) step.inertial = inertial(of, speed_mps);
    of.at_m = of.p_m;
    of.speed_mps = speed_mps;
    of.t_s = t_s_;
    ++of.nodes;
    report(v, step);
  }

  [[nodiscard]] graph::InertialFactor inertial(const Vehicle& of, double speed_mps) const {
    const double dt = t_s_ - of.t_s;
    const geometry::Vec3 g(0.0, 0.0, -9.81), v_i(of.speed_mps, 0.0, 0.0);
    graph::InertialFactor f;
    f.duration_s = dt;
    f.dv_mps = geometry::Vec3(speed_mps, 0.0, 0.0) - v_i - g * dt;
    f.dp_m = of.p_m - of.at_m - v_i * dt - 0.5 * g * dt * dt;
    f.d_rotation_d_gyro = -dt * geometry::Mat3::Identity();
    f.d_velocity_d_accel = -dt * geometry::Mat3::Identity();
    f.d_position_d_accel = -0.5 * dt * dt * geometry::Mat3::Identity();
    f.covariance.setZero();
    f.covariance.diagonal().head<3>().setConstant(1e-8);
    f.covariance.diagonal().segment<3>(3).setConstant(1e-4);
    f.covariance.diagonal().tail<3>().setConstant(1e-4);
    return f;
  }

  void stand() {
    for (double s = 0.0; s < o_.stand_s; s += 1.0) {
      t_s_ += 1.0;
      for (std::size_t v = 0; v < v_.size(); ++v) node(v, 0.0, true);
      ranges();
    }
  }

  /// Between all pairs, as recorded by the lower number.
  void ranges() {
    for (std::size_t a = 0; a + 1 < v_.size(); ++a) {
      RangeBlock block;
      for (std::size_t b = a + 1; b < v_.size(); ++b) {
        RangeEntry entry;
        entry.t = now();
        entry.from = id(a);
        entry.to = id(b);
        const double noise = std::clamp(rng_.normal(), -2.0, 2.0);
        entry.range_m = (v_[a].p_m - v_[b].p_m).norm() + 0.03 + 0.05 * noise;
        entry.sigma_m = 0.07;
        entry.T_odom_body = odom(a);
        entry.at_rest = v_[a].speed_mps == 0.0;
        block.ranges.push_back(entry);
      }
      report(a, block);
    }
  }

  RoundsForTest o_;
  Rng rng_;
  std::vector<Vehicle> v_;
  std::vector<Fact> out_, facts_of_start_;
  double t_s_ = 0.0;
  int rounds_ = 0;
};

/// Settings that stop only when nothing changes.
inline FleetSettings exact_rounds() {
  FleetSettings settings;
  settings.solve = SolveWhat::kRounds;
  settings.loops.use = false;
  settings.joint.iterations = settings.joint.iterations_easy = 100;
  settings.joint.graph.cost_change_min = 0.0;
  settings.joint.graph.step_min_m = 1e-9;
  settings.init.commit.information_min = 0.05;
  return settings;
}

}  // namespace rali::fleet
