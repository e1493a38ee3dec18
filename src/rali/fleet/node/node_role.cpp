#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "rali/fleet/node/node.hpp"

namespace rali::fleet {

using geometry::Vec3;

namespace {

/// From an anchor's first estimate to its second.
constexpr double kSecondEstimate_s = 2.0;

/// Whether a frontier is left that is not near the goal of any vehicle.
bool frontier_is_left(const GoalList& list, double taken_m) {
  const auto taken = [&](const Frontier& f) {
    return std::any_of(list.goals.begin(), list.goals.end(), [&](const Goal& g) {
      if (!g.frontier || *g.frontier >= list.frontiers.size()) return false;
      return (list.frontiers[*g.frontier].centre_map_m - f.centre_map_m).norm() <= taken_m;
    });
  };
  return !std::all_of(list.frontiers.begin(), list.frontiers.end(), taken);
}

}  // namespace

void Node::give(const RoleEvent& event) {
  RoleStep step = role_step(role_, settings_.roles, event, now_);
  role_ = std::move(step.state);
  // Write to disk before sending.
  if (step.save) out_->emplace_back(SaveRole{role_.durable, ++roles_saved_});
  for (RoleSend& send : step.messages) send_role(std::move(send));
  for (const RoleAction& action : step.actions) act(action);
}

void Node::send_role(RoleSend send) {
  send.message.number = ++role_messages_;
  send.message.revision = revision_;
  const RoleOp op = send.message.op;
  if (op == RoleOp::kFinished || op == RoleOp::kSeal) {
    send.message.inventory = op == RoleOp::kSeal && seal_ ? *seal_ : store_.inventory(0, 0);
    if (pose_) send.message.T_odom_body = pose_->T_odom_body;
  }
  // Later ones wait, too: a repeated vote is as binding as the first one.
  if (logs_ && roles_kept_ < roles_saved_) {
    waiting_roles_.emplace_back(roles_saved_, std::move(send));
    return;
  }
  post(send.to, std::move(send.message));
}

void Node::act(const RoleAction& action) {
  out_->emplace_back(action);
  switch (action.kind) {
    case RoleActionKind::kBecameAnchor:
      return became_anchor(true);
    case RoleActionKind::kRenewedTerm:
      return became_anchor(false);
    case RoleActionKind::kSealed:
      return sealed();
    case RoleActionKind::kStoppedAnchoring:
      return cancel_jobs();
    case RoleActionKind::kMayLeave:
      return;
    case RoleActionKind::kRejoined:
      // After a restart during a round: the anchor is the one named on the disk.
      if (rounds_.rounds().empty()) follow(action.vehicle);
      return;
    case RoleActionKind::kFollows:
      return follow(action.vehicle);
    case RoleActionKind::kOrphaned:
      stopped_anchoring();
      return;
    case RoleActionKind::kNotInFleet:
      return report("fleet.not_in_fleet", Severity::kError,
                    "the anchor does not count on this vehicle any more");
    case RoleActionKind::kConflict:
      return report("fleet.two_anchors", Severity::kError,
                    fmt::format("two vehicles are anchor of term {}: {} is the other one",
                                action.term, action.vehicle.value + 1));
    case RoleActionKind::kRefused:
      return;  // reported without further action
  }
}

/// A round begins, as a tag.
void Node::follow(VehicleId anchor) {
  stopped_anchoring();
  rounds_.anchor_began(anchor, now_);
  finish_.new_round(now_);
  finish_view_ = {};
  input_ = {};
  goals_.reset();
  backs_ = false;
  ranges_to_anchor_ = 0;
  rssi_dbm_ = 0.0;
  was_near_ = false;
  followed_ = now_;
  exchange_.set_points_to(anchor);
}

void Node::report_self() {
  // An old anchor must wait for ranges to the new one only where its LiDAR is degenerate. Elsewhere
  // it may leave without them, because the radios may never reach each other.
  const bool sees =
      pose_ && !pose_->degenerate && seconds_between(followed_, now_) >= settings_.roles.stand_s;
  const auto enough = static_cast<std::uint32_t>(std::ceil(settings_.roles.ranges_to_leave));
  give(RoleSelf{standing_since_, sees ? std::max(enough, ranges_to_anchor_) : ranges_to_anchor_,
                !disk_fails_});
  const bool first = self_ == role_.durable.fleet.front() && role_.durable.term == 0;
  if (!first || !pose_ || !pose_->levelled || !standing_since_ || now_ < next_claim_) return;
  next_claim_ = now_ + Duration::from_s(1.0);
  if (seconds_between(*standing_since_, now_) >= settings_.roles.stand_s) give(RoleClaim{});
}

/// Evaluates a tag's part of the round, once a second.
void Node::watch_finish() {
  const auto anchor = role_.durable.anchor;
  const bool tag = role_.mode == RoleMode::kTag && anchor && !role_.orphan && !role_.seal_received;
  if (!tag || !pose_) return;
  FinishInput input = std::exchange(input_, {});
  input.t = now_;
  const auto here = place_of(self_), there = place_of(*anchor);
  if (here && there) input.distance_m = (*here - *there).norm();
  if (goals_) {
    input.frontier_left = std::any_of(goals_->goals.begin(), goals_->goals.end(),
                                      [this](const Goal& g) { return g.vehicle == self_; });
    input.frontier_beyond = frontier_is_left(*goals_, settings_.taken_m);
  }
  input.comes_from_afar = !was_near(input);
  input.moves = is_moving();
  input.degenerate = pose_->degenerate;
  input.sigma_m = pose_->sigma_m;
  finish_view_ = finish_.step(input);
  if (finish_view_.reason != role_.finished) {
    rounds_.tag_finished(self_, finish_view_.reason);
    const bool ends = finish_view_.reason != FinishReason::kNone;
    report(
        "fleet.finished", Severity::kInfo,
        fmt::format("{} ({}; sigma {:.2f} m)", ends ? "ends its part of the round" : "drives again",
                    name_of(finish_view_.reason), pose_->sigma_m));
    give(RoleFinished{finish_view_.reason});
  }
}

/// A round may begin with tags far from their new anchor: they must not stop before they have come
/// nearer, and the anchor gives them no goal that is farther away.
bool Node::was_near(const FinishInput& input) {
  const FinishSettings& finish = settings_.rounds.finish;
  const bool received_well =
      rssi_dbm_ == 0.0 || rssi_dbm_ >= finish.rssi_stop_dbm + finish.warn_rssi_db;
  const auto apart_m = finish_.apart_m(input);
  const bool close = !apart_m || *apart_m <= finish.warn_from_m();
  // By then both radios have been received.
  const bool known = seconds_between(followed_, now_) >= settings_.roles.stand_s;
  was_near_ = was_near_ || (known && received_well && close);
  return was_near_;
}

void Node::became_anchor(bool new_round) {
  give_up_seal();
  tags_.clear();
  seal_.reset();
  revision_ = goal_revision_ = 0;
  goals_.reset();
  exchange_.set_points_to(self_);
  if (!new_round && mapper_) return;
  rounds_.anchor_began(self_, now_);
  start_mapper();
  exploration_->new_round();
  if (frontiers_received_)
    exploration_->take_over(*std::exchange(frontiers_received_, std::nullopt));
  next_estimate_ = next_look_ = next_goals_ = now_;
  estimate_after_s_ = kSecondEstimate_s;
}

/// A former anchor continues with its own map: the earlier rounds are already solved, cut and
/// drawn.
void Node::start_mapper() {
  if (!mapper_) mapper_ = std::move(resting_);
  if (mapper_) {
    add_new_facts();
  } else {
    mapper_ = std::make_unique<FleetMapper>(settings_, known_);
    exploration_ = std::make_unique<Exploration>(settings_);
    static_cast<void>(store_.take_new());
    for (const FactPtr& fact : all_facts()) {
      mapper_->add(fact);
      exploration_->add(fact);
    }
  }
  // From an anchor in between; without one its own is the last.
  const auto separator = std::exchange(separator_, std::nullopt);
  if (separator) static_cast<void>(mapper_->take_over(*separator, poses_));
}

void Node::stopped_anchoring() {
  cancel_jobs();
  give_up_seal();
  if (mapper_) resting_ = std::move(mapper_);
  tags_.clear();
  seal_.reset();
  ranked_.clear();
}

/// The round is over: a last full estimate and the exploration of its map select the next anchor.
/// Running jobs are cancelled for it.
void Node::sealed() {
  exchange_.set_points_to(std::nullopt);
  exchange_.announce();
  seal_ = store_.inventory(0, 0);
  sealed_at_ = now_;
  const bool all_finished =
      std::all_of(role_.peers.begin(), role_.peers.end(),
                  [](const RolePeer& p) { return p.finished != FinishReason::kNone; });
  const RoundEnd why = is_moving()    ? RoundEnd::kAnchorMoved
                       : all_finished ? RoundEnd::kFinished
                                      : RoundEnd::kTimeout;
  if (!mapper_) return rounds_.anchor_ended(why, now_);
  add_new_facts();
  ranked_.clear();  // of an earlier round
  sealing_ = Sealing{why};
  if (!estimating_) start_estimate(JobKind::kEndRound);
}

/// All facts of the round are solved.
void Node::solved() {
  sealing_->solved = true;
  report_separator_prior();
  if (!exploring_) start_exploration(JobKind::kNextAnchor);
}

/// The explored area, and the ranking of the next anchors, are known.
void Node::round_ended() {
  const RoundEnd why = std::exchange(sealing_, std::nullopt)->why;
  const ExploreResult& found = exploration_->result();
  const bool largest_left = exploration_->dispatcher().largest().has_value();
  const bool idle = !found.progress;
  // Recorded only; the end of the mission is decided while the anchor acts.
  if (found.mapped) note_frontiers(false);
  if (idle && found.mapped) note_stops();
  const bool all_seen = idle && found.mapped && !largest_left;
  rounds_.anchor_ended(all_seen ? RoundEnd::kExplored : why, sealed_at_);
  if (idle) return end_mission(RoundEnd::kFinished);
  ranked_ = found.next_anchors;
  report_goals();
  if (settings_.rounds.anchor.candidates == AnchorCandidates::kTags) {
    std::erase(ranked_, self_);
  }
  if (ranked_.empty()) ranked_ = {self_};
}

/// A reachable frontier was left because the vehicles that could drive had finished.
void Node::note_stops() {
  std::string ended;
  for (const VehicleId v : role_.durable.fleet) {
    const FinishReason reason = rounds_.finished(v);
    if (!forbids_driving(reason)) continue;
    ended += fmt::format("{}v{} ({})", ended.empty() ? "" : ", ", v.value + 1, name_of(reason));
  }
  for (const GoalDispatcher::Stop& stop : exploration_->result().stops) {
    std::string why(reason_of(stop.reach));
    if (stop.reach == Reach::kThere && !ended.empty()) {
      why = "a path leads there, but these ended their part of the round: " + ended;
    }
    rounds_.frontier_stopped(stop.frontier, std::move(why));
  }
}

/// Only a vehicle that holds all facts of the seal may be next; the best one is waited for a while.
void Node::offer_choice() {
  if (role_.mode != RoleMode::kSealed || role_.named || ranked_.empty() || done_) return;
  std::vector<VehicleId> able;
  for (const VehicleId v : ranked_) {
    if (v == self_ ? !disk_fails_ : (seal_ && exchange_.peer_holds(v, *seal_))) able.push_back(v);
  }
  const bool waited = seconds_between(sealed_at_, now_) >= settings_.choice_wait_s;
  if (able.empty() || (able.front() != ranked_.front() && !waited)) return;
  const auto largest = exploration_ ? exploration_->dispatcher().largest() : std::nullopt;
  rounds_.next_chosen(able.front(), largest);
  give(RoleChoice{std::move(able)});
}

}  // namespace rali::fleet
