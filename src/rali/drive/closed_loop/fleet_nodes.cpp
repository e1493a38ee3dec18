#include "rali/drive/closed_loop/fleet_nodes.hpp"

#include <algorithm>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "rali/base/assert.hpp"
#include "rali/drive/closed_loop/role_finding.hpp"
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

Finding refused(const Error& error) {
  Finding finding;
  finding.id = "fleet.message_refused";
  finding.severity = Severity::kError;
  finding.text = error.message();
  return finding;
}

/// A round as recorded by one of the mission's anchors.
struct Entry {
  fleet::RoundRow row;
  std::size_t of = 0;
};

/// Rows by time. A vehicle that was cut off or died did not record that others continued.
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
    : setup_(setup),
      ids_(ids_of(setup.names.size())),
      link_(ids_, setup.link, setup.seed),
      jobs_(setup.computer, setup.job_cost),
      now_(begin) {
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    members_.emplace_back();
    members_.back().name = setup.names[i];
    const Status started = start(i);
    RALI_ASSERT(started.has_value());  // the log is empty
  }
}

/// Starts the vehicle's software from the contents of its log.
Status FleetNodes::start(std::size_t index) {
  Member& member = members_[index];
  fleet::NodeStart from;
  if (setup_.logs) {
    auto state = StateDir::restore(member.disk.log, member.disk.slots, ids_[index], ids_);
    if (!state) return tl::make_unexpected(state.error());
    member.state = std::move(*state);
    from = member.state->take_start();
    for (Finding& finding : member.state->take_findings()) note(member, std::move(finding));
  }
  member.node = std::make_unique<fleet::Node>(ids_[index], ids_, setup_.node, setup_.known, now_,
                                              std::move(from));
  return {};
}

void FleetNodes::report(std::size_t index, const fleet::NodeEvent& event, Time t,
                        Executor& executor) {
  Member& member = members_[index];
  step(index, event, t, executor);
  if (!member.alive || !member.state) return;
  for (const fleet::NodeEvent& kept : member.state->sync(now_)) step(index, kept, t, executor);
}

void FleetNodes::step(std::size_t index, const fleet::NodeEvent& event, Time t,
                      Executor& executor) {
  const Member& member = members_[index];
  if (!member.alive) return;
  outputs_.clear();
  const double start_s = StepTimes::thread_s();
  member.node->step(event, t, outputs_);
  step_times_.add(event, StepTimes::thread_s() - start_s);
  for (const fleet::NodeOutput& output : outputs_) {
    if (setup_.watch) setup_.watch(index, output);
    if (!member.alive) return;
    obey(index, output, t, executor);
  }
}

void FleetNodes::obey(std::size_t index, const fleet::NodeOutput& output, Time t,
                      Executor& executor) {
  Member& member = members_[index];
  if (member.state && member.state->take(output)) return;
  if (const auto* envelope = std::get_if<fleet::Envelope>(&output)) {
    send(member, *envelope);
  } else if (const auto* finding = std::get_if<Finding>(&output)) {
    note(member, *finding);
  } else if (const auto* action = std::get_if<fleet::RoleAction>(&output)) {
    note(member, role_finding(*action, t));
  } else if (const auto* order = std::get_if<fleet::RunJob>(&output)) {
    jobs_.run(index, *order, now_, executor);
  } else if (const auto* cancelled = std::get_if<fleet::CancelJob>(&output)) {
    jobs_.cancel(index, cancelled->number, now_);
  }
}

void FleetNodes::collect_jobs(Executor& executor) {
  for (const SimulatedJobs::Done& done : jobs_.take(now_)) {
    report(done.owner, done.event, now_, executor);
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
      received_.push_back({received.to.value, *status});
    } else {
      report(received.to.value, received.envelope, now_, executor);
    }
  }
}

void FleetNodes::report(std::size_t index, const fleet::PeerStatus& status) {
  const Member& member = members_[index];
  if (member.alive) send(member, {status.vehicle, std::nullopt, status});
}

/// A driver reports a command one decision after it was given; earlier reports are of the previous
/// one.
void FleetNodes::report_drive(std::size_t index, const sim::DriveReport& drive,
                              Executor& executor) {
  const Member& member = members_[index];
  if (drive.goals < member.goals) return;
  report(index, fleet::DriveStatus{member.obeyed, state_of(drive.status)}, now_, executor);
}

std::vector<sim::DriveCommand> FleetNodes::decide(Time now,
                                                  std::span<const sim::DriveReport> vehicles,
                                                  Executor& executor) {
  advance(now);
  collect_jobs(executor);
  collect_mail(executor);
  std::vector<sim::DriveCommand> commands;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (i < vehicles.size()) report_drive(i, vehicles[i], executor);
    report(i, fleet::NodeTick{}, now_, executor);
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

Status FleetNodes::restart(std::size_t index) {
  Member& member = members_[index];
  if (member.alive || !setup_.logs) {
    return fail(ErrorCode::kUsage, member.name,
                member.alive ? "is alive and cannot be restarted" : "has no log to restart from");
  }
  member.past.push_back(member.node->rounds());
  member.past.back().end_of_data(now_);
  member.state.reset();
  member.disk.log->lose_power();
  *member.disk.slots = member.disk.slots->reopened();
  if (auto status = start(index); !status) return status;
  member.alive = true;
  member.stopped = false;
  member.obeyed = 0;
  link_.revive(ids_[index]);
  return {};
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
    log.reported.push_back(link_.reported(ids_[i]));
    log.explored |= members_[i].alive && members_[i].node->explored();
    std::vector<fleet::RoundMachine> lives = members_[i].past;
    lives.push_back(members_[i].node->rounds());
    lives.back().end_of_data(now_);
    for (fleet::RoundMachine& life : lives) {
      for (const fleet::RoundRow& row : life.rounds()) {
        if (row.anchor.value == i) entries.push_back({row, machines.size()});
      }
      machines.push_back(std::move(life));
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
