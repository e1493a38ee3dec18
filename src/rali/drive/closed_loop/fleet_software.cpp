#include "rali/drive/closed_loop/fleet_software.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>
#include <variant>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "rali/drive/link/post.hpp"

namespace rali::drive {
namespace {

using ScanPtr = std::shared_ptr<const sensor::LidarScan>;

std::vector<VehicleId> ids_of(std::size_t n) {
  std::vector<VehicleId> ids;
  for (std::size_t i = 0; i < n; ++i) ids.push_back({static_cast<std::uint16_t>(i)});
  return ids;
}

fleet::OwnPose own_pose(const vehicle::PoseEstimate& pose, bool levelled) {
  fleet::OwnPose own;
  own.t = pose.t;
  own.T_odom_body = pose.T_odom_body;
  own.at_rest = pose.at_rest;
  own.levelled = levelled;
  own.blind = pose.degeneracy.blind;
  own.blind_odom = pose.degeneracy.blind_odom;
  const Eigen::SelfAdjointEigenSolver<geometry::Mat3> eigen(
      pose.covariance.bottomRightCorner<3, 3>(), Eigen::EigenvaluesOnly);
  const double largest = eigen.eigenvalues().maxCoeff();
  own.sigma_m = std::isfinite(largest) && largest > 0.0 ? std::sqrt(largest) : 0.0;
  return own;
}

fleet::DriveState state_of(sim::DriveStatus status) {
  switch (status) {
    case sim::DriveStatus::kStanding:
      return fleet::DriveState::kStanding;
    case sim::DriveStatus::kDriving:
      return fleet::DriveState::kDriving;
    case sim::DriveStatus::kArrived:
      return fleet::DriveState::kArrived;
    case sim::DriveStatus::kUnreachable:
      return fleet::DriveState::kUnreachable;
  }
  return fleet::DriveState::kStanding;
}

/// What a change of role means, for people.
std::string_view text_of(fleet::RoleActionKind kind) {
  switch (kind) {
    case fleet::RoleActionKind::kBecameAnchor:
      return "is the anchor";
    case fleet::RoleActionKind::kRenewedTerm:
      return "is still the anchor";
    case fleet::RoleActionKind::kStoppedAnchoring:
      return "makes no more tables";
    case fleet::RoleActionKind::kFollows:
      return "follows a new anchor";
    case fleet::RoleActionKind::kSealed:
      return "ends its round";
    case fleet::RoleActionKind::kOrphaned:
      return "hears no anchor and stands";
    case fleet::RoleActionKind::kRejoined:
      return "hears an anchor again";
    case fleet::RoleActionKind::kMayLeave:
      return "was the anchor and may move";
    case fleet::RoleActionKind::kNotInFleet:
      return "is not counted on any more";
    case fleet::RoleActionKind::kConflict:
      return "heard of a second anchor";
    case fleet::RoleActionKind::kRefused:
      return "could not stand for election";
  }
  return "";
}

}  // namespace

ClosedLoopFleet::ClosedLoopFleet(const ClosedLoopSetup& setup, Time begin, Executor& executor)
    : executor_(executor),
      order_(setup.vehicles.empty() ? ranging::ExchangeSettings{}
                                    : setup.vehicles.front().ranging.exchange),
      link_(ids_of(setup.vehicles.size()), setup.link, setup.seed),
      now_(begin) {
  const std::vector<VehicleId> ids = ids_of(setup.vehicles.size());
  for (std::size_t i = 0; i < ids.size(); ++i) {
    Member member;
    member.name = setup.vehicles[i].name;
    member.vehicle = std::make_unique<vehicle::Vehicle>(ids[i], setup.vehicles[i]);
    member.node = std::make_unique<fleet::Node>(ids[i], ids, setup.node, setup.known, begin);
    members_.push_back(std::move(member));
  }
}

void ClosedLoopFleet::hand_over(const sim::FleetMessage& message) {
  const auto vehicle = static_cast<std::size_t>(message.vehicle);
  if (const auto* range = std::get_if<sensor::RangeSample>(&message.data)) {
    const std::size_t from = range->from.value, to = range->to.value;
    if (from >= members_.size() || to >= members_.size()) return;
    deliver(from, *range);
    deliver(to, *range);
    tell(from, fleet::HeardRange{range->to, range->range_m}, range->t);
    tell(to, fleet::HeardRange{range->from, range->range_m}, range->t);
  } else if (const auto* radio = std::get_if<sensor::RadioSample>(&message.data)) {
    tell(vehicle, fleet::HeardRadio{radio->from, radio->rssi_dbm}, radio->t);
  } else if (const auto* imu = std::get_if<sensor::ImuSample>(&message.data)) {
    deliver(vehicle, *imu);
  } else {
    deliver(vehicle, std::get<ScanPtr>(message.data));
  }
}

void ClosedLoopFleet::deliver(std::size_t to, vehicle::Event event) {
  letters_.push_back({to, std::move(event)});
  while (!letters_.empty()) {
    const Letter letter = std::move(letters_.front());
    letters_.pop_front();
    outputs_.clear();
    members_[letter.to].vehicle->step(letter.event, executor_, outputs_);
    follow(letter.to, outputs_);
  }
}

void ClosedLoopFleet::follow(std::size_t index, const vehicle::OutputList& outputs) {
  Member& member = members_[index];
  for (const vehicle::Output& output : outputs) {
    if (const auto* pose = std::get_if<vehicle::PoseEstimate>(&output)) {
      tell(index, own_pose(*pose, member.levelled), pose->t);
    } else if (const auto* made = std::get_if<vehicle::FactMade>(&output)) {
      tell(index, fleet::OwnFact{made->fact}, made->fact->t);
    } else if (const auto* status = std::get_if<vehicle::PeerStatus>(&output)) {
      member.levelled = status->pose.has_value();
      for (std::size_t i = 0; i < members_.size(); ++i) {
        if (i != index) letters_.push_back({i, *status});
      }
    } else if (const auto* finding = std::get_if<Finding>(&output)) {
      findings_.push_back(*finding);
      findings_.back().vehicle = member.name;
    }
  }
}

void ClosedLoopFleet::tell(std::size_t index, const fleet::NodeEvent& event, Time t) {
  Member& member = members_[index];
  node_outputs_.clear();
  member.node->step(event, t, executor_, node_outputs_);
  for (const fleet::NodeOutput& output : node_outputs_) {
    if (const auto* envelope = std::get_if<fleet::Envelope>(&output)) {
      if (const Status posted = post(link_, now_, *envelope); !posted) {
        Finding finding;
        finding.id = "fleet.message_refused";
        finding.severity = Severity::kError;
        finding.text = posted.error().message();
        findings_.push_back(std::move(finding));
      }
    } else if (const auto* finding = std::get_if<Finding>(&output)) {
      findings_.push_back(*finding);
      findings_.back().vehicle = member.name;
    } else if (const auto* action = std::get_if<fleet::RoleAction>(&output)) {
      Finding role;
      role.id = "fleet.role";
      role.severity = Severity::kInfo;
      role.t = t;
      role.vehicle = member.name;
      role.text = fmt::format("{} (term {})", text_of(action->kind), action->term);
      findings_.push_back(std::move(role));
    }
  }
}

void ClosedLoopFleet::collect_mail(Time now) {
  const Mail mail = collect(link_, now);
  unreadable_ += mail.unreadable;
  for (const Received& received : mail.received) {
    tell(received.to.value, received.envelope, now);
  }
}

/// The driver is told of a command one decision after it was given.
void ClosedLoopFleet::tell_drive(std::size_t index, const sim::DriveReport& report, Time now) {
  const Member& member = members_[index];
  if (report.goals < member.goals) return;
  tell(index, fleet::DriveStatus{member.obeyed, state_of(report.status)}, now);
}

std::vector<sim::DriveCommand> ClosedLoopFleet::decide(Time now,
                                                       std::span<const sim::DriveReport> vehicles) {
  now_ = std::max(now_, now);
  for (const sim::FleetMessage& message : order_.take(now)) hand_over(message);
  collect_mail(now_);
  std::vector<sim::DriveCommand> commands;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (i < vehicles.size()) tell_drive(i, vehicles[i], now_);
    tell(i, fleet::NodeTick{}, now_);
    if (auto c = command(i)) {
      if (c->kind == sim::DriveCommand::Kind::kGo && i < vehicles.size()) {
        members_[i].goals = vehicles[i].goals + 1;
      }
      commands.push_back(std::move(*c));
    }
  }
  return commands;
}

std::optional<sim::DriveCommand> ClosedLoopFleet::command(std::size_t index) {
  Member& member = members_[index];
  const fleet::DriveOrder& order = member.node->order();
  if (order.number == member.obeyed) return std::nullopt;
  sim::DriveCommand c;
  c.vehicle = static_cast<int>(index);
  c.kind = sim::DriveCommand::Kind::kStop;
  member.obeyed = order.number;
  const auto T_map_odom = member.node->T_map_odom();
  const auto& pose = member.node->pose();
  if (order.places_map_m.empty() || !T_map_odom || !pose) return c;
  c.kind = sim::DriveCommand::Kind::kGo;
  c.places_map_m = order.places_map_m;
  c.T_map_body = *T_map_odom * pose->T_odom_body;
  c.t = pose->t;
  return c;
}

bool ClosedLoopFleet::finished() const {
  return !members_.empty() && std::all_of(members_.begin(), members_.end(),
                                          [](const Member& m) { return m.node->done(); });
}

MissionLog ClosedLoopFleet::log() const {
  MissionLog log;
  log.unreadable = unreadable_;
  log.ended = finished();

  struct Entry {
    fleet::RoundRow row;
    std::size_t of = 0;
  };

  std::vector<Entry> entries;
  std::vector<fleet::RoundMachine> machines;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    machines.push_back(members_[i].node->rounds());
    machines.back().end_of_data(now_);
    log.explored |= members_[i].node->explored();
    for (const fleet::RoundRow& row : machines.back().rounds()) {
      if (row.anchor.value == i) entries.push_back({row, i});
    }
  }
  std::stable_sort(entries.begin(), entries.end(),
                   [](const Entry& a, const Entry& b) { return a.row.start < b.row.start; });
  for (Entry& entry : entries) {
    const std::uint32_t before = entry.row.round;
    entry.row.round = static_cast<std::uint32_t>(log.rounds.size() + 1);
    for (fleet::FrontierRow frontier : machines[entry.of].frontiers()) {
      if (frontier.round != before) continue;
      frontier.round = entry.row.round;
      log.frontiers.push_back(std::move(frontier));
    }
    log.rounds.push_back(entry.row);
  }
  return log;
}

}  // namespace rali::drive
