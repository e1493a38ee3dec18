#include "rali/fleet/node/node.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace rali::fleet {

using geometry::SE3;
using geometry::Vec3;

namespace {

constexpr std::size_t kTrail = 64;
constexpr double kTrailStep_m = 0.25;

/// Roll and pitch are not sent; their sigma is at most that of the heading.
geometry::Mat6 covariance_of(const PoseSigma& sigma) {
  geometry::Mat6 P = geometry::Mat6::Zero();
  P.diagonal().head<3>().setConstant(sigma.yaw_rad * sigma.yaw_rad);
  Eigen::Matrix2d turn;
  turn = Eigen::Rotation2Dd(sigma.major_azimuth_rad);
  const Eigen::Vector2d variances(sigma.major_m * sigma.major_m, sigma.minor_m * sigma.minor_m);
  P.block<2, 2>(3, 3) = turn * variances.asDiagonal() * turn.transpose();
  P(5, 5) = sigma.z_m * sigma.z_m;
  return P;
}

DurableRole role_at_start(const NodeStart& start, const std::vector<VehicleId>& fleet) {
  if (!start.durable.fleet.empty()) return start.durable;
  DurableRole durable = start.durable;
  durable.fleet = fleet;
  std::sort(durable.fleet.begin(), durable.fleet.end());
  return durable;
}

}  // namespace

Node::Node(VehicleId self, std::vector<VehicleId> fleet, const NodeSettings& settings,
           const FleetKnowledge& known, Time now, NodeStart start)
    : self_(self),
      epoch_(start.epoch),
      settings_(settings),
      known_(known),
      begin_(now),
      now_(now),
      store_(self, fleet),
      exchange_(self, fleet, settings.exchange),
      role_(start_role(self, role_at_start(start, fleet), settings.roles, now)),
      finish_(settings.rounds.finish),
      rounds_(settings.rounds),
      next_status_(now),
      next_finish_(now),
      next_claim_(now) {
  logs_ = start.logs;
  if (logs_) store_.keep_log();
  for (FactPtr& fact : start.facts) store_.restore(std::move(fact));
  if (epoch_ > 0) exchange_.go_on(epoch_, store_);
}

void Node::step(const NodeEvent& event, Time now, NodeOutputs& out) {
  now_ = std::max(now_, now);
  out_ = &out;
  std::visit([this](const auto& e) { on(e); }, event);
  for (FactPtr& fact : store_.take_unsaved()) out.emplace_back(SaveFact{std::move(fact)});
  out_ = nullptr;
}

void Node::post(std::optional<VehicleId> to, Message message) {
  out_->emplace_back(Envelope{self_, to, std::move(message)});
}

void Node::report(std::string id, Severity severity, std::string text) {
  Finding finding;
  finding.id = std::move(id);
  finding.severity = severity;
  finding.t = now_;
  finding.text = std::move(text);
  out_->emplace_back(std::move(finding));
}

void Node::on(const OwnFact& event) {
  if (!event.fact) return;
  if (const auto added = store_.add_own(*event.fact); !added) {
    report("fleet.fact_refused", Severity::kError, added.error().message());
  }
}

void Node::on(const OwnPose& event) {
  pose_ = event;
  if (event.at_rest) rested_ = event.t;
  const bool rests = rested_ && seconds_between(*rested_, event.t) <= settings_.rest_s;
  const bool drives = drive_.number == order_.number && drive_.state == DriveState::kDriving;
  if (!rests || drives) standing_since_.reset();
  if (rests && !drives && !standing_since_) standing_since_ = now_;
  const Vec3& p = event.T_odom_body.p;
  if (trail_odom_m_.empty() || (trail_odom_m_.back() - p).norm() >= kTrailStep_m) {
    trail_odom_m_.push_back(p);
    if (trail_odom_m_.size() > kTrail) trail_odom_m_.erase(trail_odom_m_.begin());
  }
}

void Node::on(const ReceivedRange& event) {
  if (role_.durable.anchor != event.peer) return;
  ++ranges_to_anchor_;
  input_.range_m = event.range_m;
}

void Node::on(const ReceivedRadio& event) {
  if (role_.durable.anchor != event.peer) return;
  // Each value counts: radios report once a second, and the median covers two.
  input_.rssi_dbm = event.rssi_dbm;
  rssi_dbm_ = event.rssi_dbm;
  watch_finish();
}

void Node::on(const DriveStatus& event) {
  const bool news = event.number != drive_.number || event.state != drive_.state;
  drive_ = event;
  if (news) next_status_ = now_;
}

std::optional<DriveEnd> Node::drive_end() const {
  const bool ended = drive_.state == DriveState::kArrived ||
                     drive_.state == DriveState::kUnreachable ||
                     drive_.state == DriveState::kBlocked || drive_.state == DriveState::kGivenUp;
  if (!ended || drive_.number != order_.number || order_.places_map_m.empty()) return std::nullopt;
  return DriveEnd{drive_.state, order_.places_map_m.back()};
}

void Node::on(const Envelope& event) {
  if (event.from == self_ || (event.to && *event.to != self_)) return;
  // Another fleet on the same radio must not end this one's mission.
  if (!std::binary_search(store_.fleet().begin(), store_.fleet().end(), event.from)) return;
  exchange_.receive(event, store_, now_);
  if (const auto* role = std::get_if<RoleMessage>(&event.message)) {
    if (role->op == RoleOp::kFinished && mapper_) {
      tags_[event.from] = role->reason;
      rounds_.tag_finished(event.from, role->reason);
    }
    const bool sealed_before = role_.seal_received;
    give(RoleReceived{event.from, *role});
    if (role_.seal_received && !sealed_before) {
      rounds_.anchor_ended(RoundEnd::kFinished, now_);
      exchange_.set_points_to(std::nullopt);
      exchange_.announce();
    }
    return;
  }
  give(RoleLink{event.from});
  if (const auto* s = std::get_if<VehicleStatus>(&event.message)) on(*s, event.from);
  if (const auto* t = std::get_if<Table>(&event.message)) on(*t, event.from);
  if (const auto* g = std::get_if<GoalList>(&event.message)) on(*g, event.from);
  if (const auto* b = std::get_if<SeparatorPrior>(&event.message)) on(*b, event.from);
}

void Node::on(const VehicleStatus& status, VehicleId from) {
  Peer& peer = peers_[from];
  if (peer.t.ns != 0) {
    const std::uint32_t epoch = peer.status.epoch;
    if (status.epoch < epoch) return;
    if (status.epoch == epoch && status.t_send < peer.status.t_send) return;
    if (status.epoch > epoch) restarted(from);
  }
  peer = {status, now_};
  if (status.mode == Mode::kDone && status.term >= role_.durable.term) done_ = true;
}

/// After its restart it may continue what it had finished before; its clock may have restarted.
void Node::restarted(VehicleId peer) {
  tags_.erase(peer);
  rounds_.tag_finished(peer, FinishReason::kNone);
  for (RolePeer& p : role_.peers) {
    if (p.vehicle != peer) continue;
    p.finished = FinishReason::kNone;
    p.finished_sent = {};
  }
}

void Node::on(const Table& table, VehicleId from) {
  if (accept_table(role_, from, table.term, table.revision)) keep(table);
}

void Node::keep(const Table& table) {
  for (const TableFrame& frame : table.frames) frames_[frame.stream] = frame.T_map_odom;
  for (const TablePose& pose : table.poses) {
    KeyframePose& known = poses_[{pose.stream.vehicle, pose.keyframe}];
    known.T_map_body = pose.T_map_body;
    known.covariance = covariance_of(pose.sigma);
  }
}

void Node::on(const SeparatorPrior& separator, VehicleId from) {
  if (separator.term != role_.durable.term || role_.durable.anchor != from) return;
  separator_ = separator;
}

void Node::on(const GoalList& goals, VehicleId from) {
  if (role_.durable.anchor != from || goals.term != role_.durable.term) return;
  const std::pair rank(goals.term, goals.revision);
  if (goals_ && rank < goals_rank_) return;
  goals_rank_ = rank;
  goals_ = goals;
  frontiers_received_ = goals.memory;
}

std::optional<SE3> Node::T_map_odom() const {
  if (mapper_) return mapper_->T_map_odom({self_, epoch_});
  std::optional<SE3> T;
  for (const auto& [stream, frame] : frames_) {
    if (stream == StreamKey{self_, epoch_}) T = frame;
  }
  return T;
}

std::optional<Vec3> Node::place_of(VehicleId vehicle) const {
  if (vehicle == self_) {
    const auto T = T_map_odom();
    return T && pose_ ? std::optional<Vec3>(*T * pose_->T_odom_body.p) : std::nullopt;
  }
  const auto peer = peers_.find(vehicle);
  if (peer == peers_.end()) return std::nullopt;
  if (mapper_) {
    const auto T = mapper_->T_map_odom({vehicle, peer->second.status.epoch});
    return T ? std::optional<Vec3>(*T * peer->second.status.T_odom_body.p) : std::nullopt;
  }
  const auto frame = frames_.find({vehicle, peer->second.status.epoch});
  if (frame == frames_.end()) return std::nullopt;
  return frame->second * peer->second.status.T_odom_body.p;
}

Mode Node::mode() const {
  if (done_) return Mode::kDone;
  if (!pose_ || !pose_->levelled) return Mode::kStarting;
  switch (role_.mode) {
    case RoleMode::kCandidate:
      return Mode::kCandidate;
    case RoleMode::kAnchor:
      return Mode::kAnchor;
    case RoleMode::kSealed:
      return Mode::kSealed;
    case RoleMode::kTag:
      break;
  }
  if (role_.orphan) return Mode::kOrphan;
  if (role_.stands_for) return Mode::kHolding;
  if (role_.finished != FinishReason::kNone) return Mode::kFinished;
  return T_map_odom() ? Mode::kExploring : Mode::kUnplaced;
}

VehicleStatus Node::status() const {
  VehicleStatus s;
  s.epoch = epoch_;
  s.term = role_.durable.term;
  s.mode = mode();
  s.at_rest = !is_moving();
  s.t_send = now_;
  s.drive_end = drive_end();
  if (!pose_) return s;
  s.T_odom_body = pose_->T_odom_body;
  s.sigma_m = pose_->sigma_m;
  if (pose_->degenerate)
    s.degenerate_azimuth_rad = std::atan2(pose_->degenerate_odom.y(), pose_->degenerate_odom.x());
  s.rssi_dbm = rssi_dbm_;
  return s;
}

void Node::on(const NodeTick&) {
  report_self();
  hold_handover();
  give(RoleTick{});
  if (now_ >= next_finish_) {
    next_finish_ = now_ + Duration::from_s(1.0);
    watch_finish();
  }
  add_new_facts();
  if (mapper_) mapper_tick();
  drive();
  if (now_ >= next_status_) {
    next_status_ = now_ + Duration::from_s(settings_.status_s);
    post(std::nullopt, status());
  }
  for (Envelope& envelope : exchange_.step(store_, now_)) out_->emplace_back(std::move(envelope));
  for (Finding& finding : store_.take_findings()) out_->emplace_back(std::move(finding));
}

}  // namespace rali::fleet
