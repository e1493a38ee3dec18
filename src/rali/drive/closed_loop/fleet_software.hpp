#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/drive/closed_loop/event_order.hpp"
#include "rali/drive/link/loopback.hpp"
#include "rali/fleet/node/node.hpp"
#include "rali/sim/fleet/closed_loop.hpp"
#include "rali/vehicle/vehicle.hpp"

namespace rali::drive {

struct ClosedLoopSetup {
  std::vector<vehicle::VehicleSettings> vehicles;  ///< by number
  fleet::NodeSettings node;
  fleet::FleetKnowledge known;
  LinkSettings link;  ///< between any two; lossless unless told otherwise
  std::uint64_t seed = 1;
};

/// How a mission ended, as the fleet's software sees it.
struct MissionLog {
  std::vector<fleet::RoundRow> rounds;        ///< each as its anchor had it
  std::vector<fleet::FrontierRow> frontiers;  ///< `round` is that of `rounds`
  bool explored = false;                      ///< no open frontier was left
  bool ended = false;                         ///< by the fleet itself
  std::uint64_t unreadable = 0;               ///< messages
};

/// The fleet's software on simulated vehicles: what `rali map` runs for each vehicle, its part in
/// the fleet, and a radio of bytes between them. Same simulation and settings: same commands,
/// whatever the number of threads.
class ClosedLoopFleet final : public sim::FleetSoftware {
 public:
  /// `executor` must outlive the object.
  ClosedLoopFleet(const ClosedLoopSetup& setup, Time begin, Executor& executor);

  void on_message(const sim::FleetMessage& message) override { order_.add(message); }

  [[nodiscard]] std::vector<sim::DriveCommand> decide(
      Time now, std::span<const sim::DriveReport> vehicles) override;

  [[nodiscard]] bool finished() const override;

  [[nodiscard]] MissionLog log() const;

  /// Findings of vehicles and nodes so far, each with its vehicle's name.
  [[nodiscard]] FindingList take_findings() { return std::exchange(findings_, {}); }

  [[nodiscard]] const fleet::Node& node(std::size_t vehicle) const {
    return *members_[vehicle].node;
  }

  [[nodiscard]] std::size_t size() const { return members_.size(); }

  [[nodiscard]] const Loopback& radio() const { return link_; }

 private:
  struct Member {
    std::string name;
    std::unique_ptr<vehicle::Vehicle> vehicle;
    std::unique_ptr<fleet::Node> node;
    bool levelled = false;
    std::uint64_t obeyed = 0;  ///< number of the last order that became a command
    std::uint64_t goals = 0;   ///< of the driver, when that command was given
  };

  struct Letter {
    std::size_t to;
    vehicle::Event event;
  };

  void hand_over(const sim::FleetMessage& message);
  void deliver(std::size_t to, vehicle::Event event);
  void follow(std::size_t index, const vehicle::OutputList& outputs);
  void tell(std::size_t index, const fleet::NodeEvent& event, Time t);
  void collect_mail(Time now);
  void tell_drive(std::size_t index, const sim::DriveReport& report, Time now);
  [[nodiscard]] std::optional<sim::DriveCommand> command(std::size_t index);

  Executor& executor_;
  EventOrder order_;
  Loopback link_;
  std::vector<Member> members_;
  std::deque<Letter> letters_;
  vehicle::OutputList outputs_;
  fleet::NodeOutputs node_outputs_;
  FindingList findings_;
  Time now_;  ///< of the last decision: the radio's clock
  std::uint64_t unreadable_ = 0;
};

}  // namespace rali::drive
