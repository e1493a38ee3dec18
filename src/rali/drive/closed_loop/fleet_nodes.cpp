#include "rali/drive/closed_loop/fleet_nodes.hpp"

#include <algorithm>
#include <string_view>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "rali/drive/link/post.hpp"

namespace rali::drive {
namespace {

std::vector<VehicleId> ids_of(std::size_t n) {
  std::vector<VehicleId> ids;
  for (std::size_t i = 0; i < n; ++i) ids.push_back({static_cast<std::uint16_t>(i)});
  return ids;
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
    case sim::DriveStatus::kBlocked:
      return fleet::DriveState::kBlocked;
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
      return "receives no anchor and stops";
    case fleet::RoleActionKind::kRejoined:
      return "receives an anchor again";
    case fleet::RoleActionKind::kMayLeave:
      return "was the anchor and may move";
    case fleet::RoleActionKind::kNotInFleet:
      return "is not counted on any more";
    case fleet::RoleActionKind::kConflict:
      return "received a second anchor";
    case fleet::RoleActionKind::kRefused:
      return "could not be elected";
  }
  return "";
}

Finding refused(const Error& error) {
  Finding finding;
  finding.id = "fleet.message_refused";
  finding.severity = Severity::kError;
  finding.text = error.message();
  return finding;
}

Finding role_change(const fleet::RoleAction& action, Time t) {
  Finding finding;
  finding.id = "fleet.role";
  finding.severity = Severity::kInfo;
  finding.t = t;
  finding.text = fmt::format("{} (term {})", text_of(action.kind), action.term);
  return finding;
}

/// A round as one of its mission's anchors had it.
struct Entry {
  fleet::RoundRow row;
  std::size_t of = 0;
};

/// Rows by time. Who was cut off or died does not know that others went on without it.
void put_in_order(std::vector<Entry>& entries) {
  std::stable_sort(entries.begin(), entries.end(),
                   [](const Entry& a, const Entry& b) { return a.row.start < b.row.start; });
  for (std::size_t k = 0; k + 1 < entries.size(); ++k) {
    fleet::RoundRow& row = entries[k].row;
    const fleet::RoundRow& next = entries[k + 1].row;
    if (row.ended_by != fleet::RoundEnd::kEndOfData) continue;
    row.ended_by = fleet::RoundEnd::kAnchorLost;
    row.end = next.start;
    row.next_anchor = next.anchor;
  }
}

}  // namespace

FleetNodes::FleetNodes(const FleetNodesSetup& setup, Time begin)
    : link_(ids_of(setup.names.size()), setup.link, setup.seed),
      jobs_(setup.computer, setup.job_cost),
      now_(begin) {
  const std::vector<VehicleId> ids = ids_of(setup.names.size());
  for (std::size_t i = 0; i < ids.size(); ++i) {
    Member member;
    member.name = setup.names[i];
    member.node = std::make_unique<fleet::Node>(ids[i], ids, setup.node, setup.known, begin);
    members_.push_back(std::move(member));
  }
}

void FleetNodes::tell(std::size_t index, const fleet::NodeEvent& event, Time t,
                      Executor& executor) {
  Member& member = members_[index];
  if (!member.alive) return;
  outputs_.clear();
  const double begin_s = StepTimes::thread_s();
  member.node->step(event, t, outputs_);
  step_times_.add(event, StepTimes::thread_s() - begin_s);
  for (const fleet::NodeOutput& output : outputs_) follow(index, output, t, executor);
}

void FleetNodes::follow(std::size_t index, const fleet::NodeOutput& output, Time t,
                        Executor& executor) {
  const Member& member = members_[index];
  if (const auto* envelope = std::get_if<fleet::Envelope>(&output)) {
    send(member, *envelope);
  } else if (const auto* finding = std::get_if<Finding>(&output)) {
    note(member, *finding);
  } else if (const auto* action = std::get_if<fleet::RoleAction>(&output)) {
    note(member, role_change(*action, t));
  } else if (const auto* order = std::get_if<fleet::RunJob>(&output)) {
    jobs_.run(index, *order, now_, executor);
  } else if (const auto* cancelled = std::get_if<fleet::CancelJob>(&output)) {
    jobs_.cancel(index, cancelled->number, now_);
  }
}

void FleetNodes::collect_jobs(Executor& executor) {
  for (const SimulatedJobs::Done& done : jobs_.take(now_)) {
    tell(done.owner, done.event, now_, executor);
  }
}

void FleetNodes::note(const Member& member, Finding finding) {
  finding.vehicle = member.name;
  findings_.push_back(std::move(finding));
}

void FleetNodes::send(const Member& member, const fleet::Envelope& envelope) {
  const Status posted = post(link_, now_, envelope);
  if (!posted) note(member, refused(posted.error()));
}

void FleetNodes::collect_mail(Executor& executor) {
  const Mail mail = collect(link_, now_);
  unreadable_ += mail.unreadable;
  for (const Received& received : mail.received) {
    if (const auto* status = std::get_if<fleet::PeerStatus>(&received.envelope.message)) {
      heard_.push_back({received.to.value, *status});
    } else {
      tell(received.to.value, received.envelope, now_, executor);
    }
  }
}

void FleetNodes::say(std::size_t index, const fleet::PeerStatus& status) {
  const Member& member = members_[index];
  if (member.alive) send(member, {status.vehicle, std::nullopt, status});
}

/// The driver is told of a command one decision after it was given.
void FleetNodes::tell_drive(std::size_t index, const sim::DriveReport& report, Executor& executor) {
  const Member& member = members_[index];
  if (report.goals < member.goals) return;
  tell(index, fleet::DriveStatus{member.obeyed, state_of(report.status)}, now_, executor);
}

std::vector<sim::DriveCommand> FleetNodes::decide(Time now,
                                                  std::span<const sim::DriveReport> vehicles,
                                                  Executor& executor) {
  advance(now);
  collect_jobs(executor);
  collect_mail(executor);
  std::vector<sim::DriveCommand> commands;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (i < vehicles.size()) tell_drive(i, vehicles[i], executor);
    tell(i, fleet::NodeTick{}, now_, executor);
    if (auto c = command(i)) {
      if (c->kind == sim::DriveCommand::Kind::kGo && i < vehicles.size()) {
        members_[i].goals = vehicles[i].goals + 1;
      }
      commands.push_back(std::move(*c));
    }
  }
  return commands;
}

std::optional<sim::DriveCommand> FleetNodes::command(std::size_t index) {
  Member& member = members_[index];
  const fleet::DriveOrder& order = member.node->order();
  sim::DriveCommand c;
  c.vehicle = static_cast<int>(index);
  c.kind = sim::DriveCommand::Kind::kStop;
  if (!member.alive) {
    return std::exchange(member.stopped, true) ? std::nullopt : std::optional(c);
  }
  if (order.number == member.obeyed) return std::nullopt;
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

void FleetNodes::kill(std::size_t index) {
  members_[index].alive = false;
  jobs_.forget(index);
  link_.kill({static_cast<std::uint16_t>(index)});
}

bool FleetNodes::finished() const {
  const auto goes_on = [](const Member& m) { return m.alive && !m.node->done(); };
  const auto lives = [](const Member& m) { return m.alive; };
  return std::any_of(members_.begin(), members_.end(), lives) &&
         std::none_of(members_.begin(), members_.end(), goes_on);
}

MissionLog FleetNodes::log() const {
  MissionLog log;
  log.unreadable = unreadable_;
  log.ended = finished();
  std::vector<Entry> entries;
  std::vector<fleet::RoundMachine> machines;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    log.said.push_back(link_.said({static_cast<std::uint16_t>(i)}));
    machines.push_back(members_[i].node->rounds());
    machines.back().end_of_data(now_);
    log.explored |= members_[i].alive && members_[i].node->explored();
    for (const fleet::RoundRow& row : machines.back().rounds()) {
      if (row.anchor.value == i) entries.push_back({row, i});
    }
  }
  put_in_order(entries);
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
