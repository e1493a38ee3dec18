#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/drive/closed_loop/event_order.hpp"
#include "rali/drive/closed_loop/fleet_nodes.hpp"
#include "rali/vehicle/vehicle.hpp"

namespace rali::drive {

struct ClosedLoopSetup {
  std::vector<vehicle::VehicleSettings> vehicles;  ///< by number
  FleetNodesSetup fleet;
};

/// The fleet software on simulated vehicles: the odometry of `rali map` and a fleet node for each
/// vehicle, and a byte-level radio between them. Same simulation and settings give the same
/// commands, for any number of threads.
class ClosedLoopFleet final : public sim::FleetSoftware {
 public:
  /// `executor` must outlive the object.
  ClosedLoopFleet(const ClosedLoopSetup& setup, Time begin, Executor& executor);

  void on_message(const sim::FleetMessage& message) override { order_.add(message); }

  [[nodiscard]] std::vector<sim::DriveCommand> decide(
      Time now, std::span<const sim::DriveReport> vehicles) override;

  [[nodiscard]] bool finished() const override { return nodes_.finished(); }

  /// Restarts a killed vehicle (nodes().kill): its fleet node from its log, its odometry from
  /// scratch, in its next epoch. Errors: those of FleetNodes::restart.
  [[nodiscard]] Status restart(std::size_t index);

  [[nodiscard]] MissionLog log() const { return nodes_.log(); }

  /// Findings of vehicles and nodes so far, each with its vehicle's name.
  [[nodiscard]] FindingList take_findings();

  [[nodiscard]] FleetNodes& nodes() { return nodes_; }

  [[nodiscard]] const FleetNodes& nodes() const { return nodes_; }

 private:
  struct Member {
    std::unique_ptr<vehicle::Vehicle> vehicle;
    bool levelled = false;
  };

  void hand_over(const sim::FleetMessage& message);
  void deliver(std::size_t to, const vehicle::Event& event);
  void follow(std::size_t index, const vehicle::OutputList& outputs);
  void report(std::size_t index, const fleet::NodeEvent& event, Time t);

  std::vector<vehicle::VehicleSettings> settings_;
  Executor& executor_;
  EventOrder order_;
  FleetNodes nodes_;
  std::vector<Member> members_;
  vehicle::OutputList outputs_;
  FindingList findings_;
};

}  // namespace rali::drive
