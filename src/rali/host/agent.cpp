#include "rali/host/agent.hpp"

#include <utility>

#include "rali/drive/closed_loop/own_pose.hpp"
#include "rali/drive/closed_loop/role_finding.hpp"
#include "rali/wire/fleet/codec.hpp"

namespace rali::host {
namespace {

std::vector<VehicleId> ids_of_fleet(std::size_t n) {
  std::vector<VehicleId> ids;
  for (std::size_t i = 0; i < n; ++i) ids.push_back({static_cast<std::uint16_t>(i)});
  return ids;
}

net::Urgency urgency_of(const fleet::Message& message) {
  if (std::holds_alternative<fleet::RoleMessage>(message)) return net::Urgency::kRole;
  const bool bulk = std::holds_alternative<fleet::FactMessage>(message) ||
                    std::holds_alternative<fleet::Table>(message) ||
                    std::holds_alternative<fleet::SeparatorPrior>(message);
  return bulk ? net::Urgency::kBulk : net::Urgency::kStatus;
}

Finding refused_message(const Error& error, Time t) {
  Finding finding;
  finding.id = "fleet.message_refused";
  finding.severity = Severity::kError;
  finding.t = t;
  finding.text = error.message();
  return finding;
}

}  // namespace

Agent::Agent(const AgentSetup& setup, Time now)
    : self_(setup.self),
      names_(setup.names),
      arrive_m_(setup.node.arrive_m),
      node_(setup.self, ids_of_fleet(setup.names.size()), setup.node, setup.known, now,
            setup.start) {}

void Agent::take(const vehicle::Output& output, Time now, AgentOutputs& out) {
  if (const auto* pose = std::get_if<vehicle::PoseEstimate>(&output)) {
    pose_ = *pose;
    step(drive::own_pose(*pose, levelled_), now, out);
  } else if (const auto* made = std::get_if<vehicle::FactMade>(&output)) {
    step(fleet::OwnFact{made->fact}, now, out);
  } else if (const auto* status = std::get_if<vehicle::PeerStatus>(&output)) {
    levelled_ = status->pose.has_value();
    pass_on({self_, std::nullopt, *status}, out);
  } else if (const auto* finding = std::get_if<Finding>(&output)) {
    out.emplace_back(*finding);
  }
}

void Agent::take(const sensor::RangeSample& range, Time now, AgentOutputs& out) {
  const bool forth = range.from == self_;
  if (!forth && range.to != self_) return;
  step(fleet::ReceivedRange{forth ? range.to : range.from, range.range_m}, now, out);
}

void Agent::take(const sensor::RadioSample& radio, Time now, AgentOutputs& out) {
  if (radio.from.value < names_.size()) {
    step(fleet::ReceivedRadio{radio.from, radio.rssi_dbm}, now, out);
  }
}

void Agent::receive(VehicleId from, std::span<const std::byte> bytes, Time now, AgentOutputs& out) {
  const Result<fleet::Envelope> envelope = wire::decode_envelope(bytes);
  if (!envelope) {
    ++tally_.unreadable;
    return;
  }
  // A vehicle must not send messages in the name of another.
  if (envelope->from != from || from.value >= names_.size()) {
    ++tally_.wrong_sender;
    return;
  }
  if (envelope->to && *envelope->to != self_) return;
  if (const auto* status = std::get_if<fleet::PeerStatus>(&envelope->message)) {
    if (status->vehicle == from) out.emplace_back(PeerReport{*status});
    return;
  }
  note(envelope->message, from, now);
  step(*envelope, now, out);
}

void Agent::tick(Time now, AgentOutputs& out) {
  step(drive_status(), now, out);
  step(fleet::NodeTick{}, now, out);
}

/// A navigation reports the state of the drive itself. For a driver who follows /goal_pose without
/// reporting, the motion decides: a vehicle at standstill elsewhere has not given up, it may wait.
fleet::DriveStatus Agent::drive_status() const {
  fleet::DriveStatus status{node_.order().number, fleet::DriveState::kStanding};
  const auto& places = node_.order().places_map_m;
  const auto T_map_odom = node_.T_map_odom();
  if (places.empty() || !pose_ || !T_map_odom) return status;
  if (const auto reported = goal_watch_.state()) {
    status.state = *reported;
    return status;
  }
  const geometry::Vec3 p_map = *T_map_odom * pose_->T_odom_body.p;
  const bool there = (p_map - places.back()).head<2>().norm() <= arrive_m_;
  if (there && pose_->at_rest) status.state = fleet::DriveState::kArrived;
  if (!pose_->at_rest) status.state = fleet::DriveState::kDriving;
  return status;
}

void Agent::step(const fleet::NodeEvent& event, Time now, AgentOutputs& out) {
  node_out_.clear();
  node_.step(event, now, node_out_);
  goal_watch_.sent(node_.order().number);
  for (fleet::NodeOutput& output : node_out_) {
    if (const auto* envelope = std::get_if<fleet::Envelope>(&output)) {
      note(envelope->message, self_, now);
      pass_on(*envelope, out);
    } else if (auto* finding = std::get_if<Finding>(&output)) {
      out.emplace_back(std::move(*finding));
    } else if (const auto* action = std::get_if<fleet::RoleAction>(&output)) {
      out.emplace_back(*action);
      out.emplace_back(drive::role_finding(*action, now));
    } else if (auto* save = std::get_if<fleet::SaveRole>(&output)) {
      out.emplace_back(std::move(*save));
    } else if (auto* fact = std::get_if<fleet::SaveFact>(&output)) {
      out.emplace_back(std::move(*fact));
    } else if (auto* job = std::get_if<fleet::RunJob>(&output)) {
      out.emplace_back(std::move(*job));
    } else if (const auto* cancelled = std::get_if<fleet::CancelJob>(&output)) {
      out.emplace_back(*cancelled);
    }
  }
}

void Agent::pass_on(const fleet::Envelope& envelope, AgentOutputs& out) {
  if (names_.size() < 2) return;
  Result<wire::Bytes> bytes = wire::encode_envelope(envelope);
  if (!bytes) {
    out.emplace_back(refused_message(bytes.error(), Time{}));
    return;
  }
  out.emplace_back(SendBytes{envelope.to, urgency_of(envelope.message), std::move(*bytes)});
}

/// Keeps messages for the view.
void Agent::note(const fleet::Message& message, VehicleId from, Time now) {
  if (const auto* status = std::get_if<fleet::VehicleStatus>(&message)) {
    received_[from] = {*status, now};
  } else if (const auto* goals = std::get_if<fleet::GoalList>(&message)) {
    if (!anchor() || anchor() == from) goals_ = *goals;
  }
}

}  // namespace rali::host
