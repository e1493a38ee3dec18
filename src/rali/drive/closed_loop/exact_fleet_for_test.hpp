#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "rali/drive/closed_loop/fleet_nodes.hpp"
#include "rali/fleet/facts/keyframe_number.hpp"
#include "rali/sim/fleet/closed_loop.hpp"
#include "rali/sim/fleet/fleet_simulation.hpp"

namespace rali::drive {

/// The fleet software with vehicles that have exact poses and make keyframes of exact rays:
/// missions of many minutes in seconds. Only the fleet's decisions are under test.
class ExactFleet final : public sim::FleetSoftware {
 public:
  /// @param sim not scripted, without LiDAR and inertial sensor
  /// @param logs vehicles keep logs and can be restarted
  ExactFleet(sim::FleetSimulation& sim, const fleet::NodeSettings& settings, bool logs)
      : ExactFleet(sim, settings, ComputerSettings{}, JobCost{}, logs) {}

  explicit ExactFleet(sim::FleetSimulation& sim, const fleet::NodeSettings& settings,
                      const ComputerSettings& computer = {}, const JobCost& job_cost = {},
                      bool logs = false)
      : sim_(sim),
        caster_(sim.mesh()),
        nodes_(setup_of(sim, settings, computer, job_cost, logs), sim.t_start()) {
    for (int v = 0; v < sim.vehicles(); ++v) {
      Vehicle vehicle;
      vehicle.T_odom_world = sim.truth(v, sim.t_start()).state.T_world_body.inverse();
      vehicles_.push_back(std::move(vehicle));
    }
  }

  void on_message(const sim::FleetMessage& message) override {
    if (const auto* range = std::get_if<sensor::RangeSample>(&message.data)) {
      received_range(range->from, range->to, *range);
      received_range(range->to, range->from, *range);
    } else if (const auto* radio = std::get_if<sensor::RadioSample>(&message.data)) {
      if (!nodes_.alive(radio->from.value)) return;
      const auto to = static_cast<std::size_t>(message.vehicle);
      nodes_.report(to, fleet::ReceivedRadio{radio->from, radio->rssi_dbm}, radio->t, executor_);
    }
  }

  std::vector<sim::DriveCommand> decide(Time now,
                                        std::span<const sim::DriveReport> vehicles) override {
    nodes_.advance(now);
    for (std::size_t v = 0; v < vehicles_.size(); ++v) measure(v, now);
    if (on_time) on_time(now);
    watch();
    return nodes_.decide(now, vehicles, executor_);
  }

  [[nodiscard]] bool finished() const override { return nodes_.finished(); }

  [[nodiscard]] FleetNodes& nodes() { return nodes_; }

  /// Restarts a killed vehicle; a new odom starts at its current pose.
  [[nodiscard]] Status restart(std::size_t v, Time now) {
    if (auto status = nodes_.restart(v); !status) return status;
    vehicles_[v] = {};
    vehicles_[v].T_odom_world = sim_.truth(static_cast<int>(v), now).state.T_world_body.inverse();
    return {};
  }

  std::function<void(Time)> on_time;  ///< before each decision
  /// Receives each output of a node before it takes effect; may kill the vehicle.
  std::function<void(std::size_t, const fleet::NodeOutput&)> on_output;
  std::size_t most_anchors = 0;  ///< maximum number of anchors acting at one time

 private:
  struct Vehicle {
    geometry::SE3 T_odom_world;
    std::uint32_t facts = 0, path_nodes = 0, keyframes = 0;
    std::optional<geometry::SE3> last_keyframe;
    Time last_node, last_range;
  };

  FleetNodesSetup setup_of(const sim::FleetSimulation& sim, const fleet::NodeSettings& settings,
                           const ComputerSettings& computer, const JobCost& job_cost, bool logs) {
    FleetNodesSetup setup;
    setup.logs = logs;
    setup.watch = [this](std::size_t v, const fleet::NodeOutput& output) {
      if (on_output) on_output(v, output);
    };
    setup.node = settings;
    setup.computer = computer;
    setup.job_cost = job_cost;
    const geometry::SE3 T_v1_world = sim.truth(0, sim.t_start()).state.T_world_body.inverse();
    for (int v = 0; v < sim.vehicles(); ++v) {
      setup.names.push_back(fmt::format("v{}", v + 1));
      if (v == 0) continue;
      fleet::GivenStart start;
      start.relative_to = VehicleId{0};
      start.vehicle = VehicleId{static_cast<std::uint16_t>(v)};
      start.T_relative_vehicle = T_v1_world * sim.truth(v, sim.t_start()).state.T_world_body;
      setup.known.starts.push_back(start);
    }
    return setup;
  }

  void received_range(VehicleId self, VehicleId peer, const sensor::RangeSample& range) {
    if (!nodes_.alive(self.value) || !nodes_.alive(peer.value)) return;
    nodes_.report(self.value, fleet::ReceivedRange{peer, range.range_m}, range.t, executor_);
  }

  void fact(std::size_t v, Time t, fleet::FactBody body) {
    const VehicleId id{static_cast<std::uint16_t>(v)};
    const std::uint32_t epoch = nodes_.node(v).epoch();
    const fleet::Fact made{{id, epoch, vehicles_[v].facts++}, t, std::move(body)};
    nodes_.report(v, fleet::OwnFact{std::make_shared<const fleet::Fact>(made)}, t, executor_);
  }

  /// Its pose, ten times a second; a node of its path each second, a keyframe each metre.
  void measure(std::size_t v, Time now) {
    Vehicle& self = vehicles_[v];
    if (!nodes_.alive(v)) return;
    const sim::MotionState state = sim_.truth(static_cast<int>(v), now).state;
    fleet::OwnPose pose;
    pose.t = now;
    pose.T_odom_body = self.T_odom_world * state.T_world_body;
    pose.at_rest = state.v_world_mps.norm() < 0.02 && state.omega_body_radps.norm() < 0.02;
    pose.levelled = true;
    nodes_.report(v, pose, now, executor_);
    const bool first = !self.last_keyframe;
    if (first) fact(v, now, fleet::EpochStart{nodes_.name(v), {geometry::Vec3::Zero()}});
    if (!nodes_.alive(v)) return;
    const geometry::SE3 step =
        first ? geometry::SE3{} : self.last_keyframe->inverse() * pose.T_odom_body;
    const bool keyframe = first || step.p.norm() > 1.0 || geometry::so3_log(step.R).norm() > 0.5;
    if (!keyframe && seconds_between(self.last_node, now) < 1.0) return;
    write(v, now, pose, keyframe);
    if (keyframe) self.last_keyframe = pose.T_odom_body;
  }

  void write(std::size_t v, Time now, const fleet::OwnPose& pose, bool keyframe) {
    Vehicle& self = vehicles_[v];
    fleet::Increment step;
    step.node = self.path_nodes++;
    if (keyframe) {
      step.keyframe = fleet::first_keyframe_of(nodes_.node(v).epoch()) + self.keyframes++;
    }
    step.begins = step.node == 0;
    step.at_rest = pose.at_rest;
    step.levelled = true;
    step.T_odom_body = pose.T_odom_body;
    step.covariance = geometry::Mat6::Identity() * 1e-6;
    step.lidar_information = geometry::Mat6::Identity() * 1e6;
    fact(v, now, step);
    self.last_node = now;
    if (keyframe) fact(v, now, points_of(*step.keyframe, v, now));
  }

  /// The points of 16 rings of 300 rays, without other vehicles.
  fleet::KeyframePoints points_of(std::uint32_t number, std::size_t v, Time now) {
    constexpr int kRings = 16, kRays = 300;
    constexpr double kReach_m = 60.0;
    const int vehicle = static_cast<int>(v);
    const geometry::SE3 T_world_body = sim_.truth(vehicle, now).state.T_world_body;
    fleet::KeyframePoints points;
    fleet::PointArrays arrays;
    points.keyframe = number;
    points.T_body_lidar = sim_.calibration_true(vehicle).T_body_lidar;
    const geometry::SE3 T_world_lidar = T_world_body * points.T_body_lidar;
    for (int k = 0; k < kRings * kRays; ++k) {
      const double up = (2.0 * (k % kRings) - 15.0) * std::numbers::pi / 180.0;
      const double turn = 2.0 * std::numbers::pi * (k / kRings) / kRays;
      const geometry::Vec3 d(std::cos(up) * std::cos(turn), std::cos(up) * std::sin(turn),
                             std::sin(up));
      const sim::Hit hit = caster_.cast(T_world_lidar.p, T_world_lidar.R * d, kReach_m);
      if (!(hit.range_m > 0.0F)) continue;
      const geometry::Vec3 p = points.T_body_lidar * (static_cast<double>(hit.range_m) * d);
      arrays.push_back(static_cast<float>(p.x()), static_cast<float>(p.y()),
                       static_cast<float>(p.z()));
    }
    points.points = fleet::PackedPoints(arrays);
    return points;
  }

  void watch() {
    std::size_t anchors = 0;
    for (std::size_t v = 0; v < nodes_.size(); ++v) {
      anchors += nodes_.alive(v) && nodes_.node(v).mode() == fleet::Mode::kAnchor ? 1 : 0;
    }
    most_anchors = std::max(most_anchors, anchors);
  }

  sim::FleetSimulation& sim_;
  sim::RayCaster caster_;
  FleetNodes nodes_;
  SerialExecutor executor_;
  std::vector<Vehicle> vehicles_;
};

}  // namespace rali::drive
