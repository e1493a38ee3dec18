#include "rali/drive/closed_loop/fleet_software.hpp"

#include <variant>

#include "rali/drive/closed_loop/own_pose.hpp"

namespace rali::drive {
namespace {

using ScanPtr = std::shared_ptr<const sensor::LidarScan>;

}  // namespace

ClosedLoopFleet::ClosedLoopFleet(const ClosedLoopSetup& setup, Time begin, Executor& executor)
    : settings_(setup.vehicles),
      executor_(executor),
      order_(setup.vehicles.empty() ? ranging::ExchangeSettings{}
                                    : setup.vehicles.front().ranging.exchange),
      nodes_(setup.fleet, begin) {
  for (std::size_t i = 0; i < setup.vehicles.size(); ++i) {
    const VehicleId id{static_cast<std::uint16_t>(i)};
    members_.push_back({std::make_unique<vehicle::Vehicle>(id, setup.vehicles[i]), false});
  }
}

Status ClosedLoopFleet::restart(std::size_t index) {
  if (auto status = nodes_.restart(index); !status) return status;
  vehicle::VehicleSettings settings = settings_[index];
  settings.facts.epoch = nodes_.node(index).epoch();
  const VehicleId id{static_cast<std::uint16_t>(index)};
  members_[index] = {std::make_unique<vehicle::Vehicle>(id, settings), false};
  return {};
}

void ClosedLoopFleet::hand_over(const sim::FleetMessage& message) {
  const auto vehicle = static_cast<std::size_t>(message.vehicle);
  if (const auto* range = std::get_if<sensor::RangeSample>(&message.data)) {
    const std::size_t from = range->from.value, to = range->to.value;
    if (from >= members_.size() || to >= members_.size()) return;
    if (!nodes_.alive(from) || !nodes_.alive(to)) return;  // a dead vehicle's radio is dead, too
    deliver(from, *range);
    deliver(to, *range);
    report(from, fleet::ReceivedRange{range->to, range->range_m}, range->t);
    report(to, fleet::ReceivedRange{range->from, range->range_m}, range->t);
  } else if (const auto* radio = std::get_if<sensor::RadioSample>(&message.data)) {
    if (radio->from.value >= members_.size() || !nodes_.alive(radio->from.value)) return;
    report(vehicle, fleet::ReceivedRadio{radio->from, radio->rssi_dbm}, radio->t);
  } else if (const auto* imu = std::get_if<sensor::ImuSample>(&message.data)) {
    deliver(vehicle, *imu);
  } else {
    deliver(vehicle, std::get<ScanPtr>(message.data));
  }
}

void ClosedLoopFleet::deliver(std::size_t to, const vehicle::Event& event) {
  if (!nodes_.alive(to)) return;
  outputs_.clear();
  members_[to].vehicle->step(event, executor_, outputs_);
  follow(to, outputs_);
}

void ClosedLoopFleet::follow(std::size_t index, const vehicle::OutputList& outputs) {
  Member& member = members_[index];
  for (const vehicle::Output& output : outputs) {
    if (const auto* pose = std::get_if<vehicle::PoseEstimate>(&output)) {
      report(index, own_pose(*pose, member.levelled), pose->t);
    } else if (const auto* made = std::get_if<vehicle::FactMade>(&output)) {
      report(index, fleet::OwnFact{made->fact}, made->fact->t);
    } else if (const auto* status = std::get_if<vehicle::PeerStatus>(&output)) {
      member.levelled = status->pose.has_value();
      fleet::PeerStatus reported = *status;
      // Peers know its pose in the odom frame of its first start; after a restart that frame is
      // lost.
      if (nodes_.node(index).epoch() > 0) reported.pose.reset();
      nodes_.report(index, reported);
    } else if (const auto* finding = std::get_if<Finding>(&output)) {
      findings_.push_back(*finding);
      findings_.back().vehicle = nodes_.name(index);
    }
  }
}

void ClosedLoopFleet::report(std::size_t index, const fleet::NodeEvent& event, Time t) {
  nodes_.report(index, event, t, executor_);
}

std::vector<sim::DriveCommand> ClosedLoopFleet::decide(Time now,
                                                       std::span<const sim::DriveReport> vehicles) {
  nodes_.advance(now);
  for (const sim::FleetMessage& message : order_.take(now)) hand_over(message);
  std::vector<sim::DriveCommand> commands = nodes_.decide(now, vehicles, executor_);
  for (const FleetNodes::ReceivedStatus& received : nodes_.take_received()) {
    deliver(received.to, received.status);
  }
  return commands;
}

FindingList ClosedLoopFleet::take_findings() {
  FindingList out = std::exchange(findings_, {});
  for (Finding& finding : nodes_.take_findings()) out.push_back(std::move(finding));
  return out;
}

}  // namespace rali::drive
