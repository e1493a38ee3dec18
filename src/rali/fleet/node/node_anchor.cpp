#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "rali/fleet/node/node.hpp"

namespace rali::fleet {

using geometry::SE3;
using geometry::Vec3;

void Node::add_new_facts() {
  for (const FactPtr& fact : store_.take_new()) {
    if (FleetMapper* mapper = any_mapper()) mapper->add(fact);
    if (exploration_) exploration_->add(fact);
  }
}

void Node::mapper_tick() {
  if (role_.mode == RoleMode::kSealed) return offer_choice();
  if (!may_publish(role_, now_) || done_) return;
  if (now_ >= next_estimate_ && !estimating_) {
    next_estimate_ = now_ + Duration::from_s(next_estimate_after_s());
    start_estimate(JobKind::kEstimate);
  }
  if (now_ >= next_look_ && !exploring_) {
    next_look_ = now_ + Duration::from_s(settings_.look_s);
    start_exploration(JobKind::kExplore);
  }
}

/// Twice as long each time, from a new anchor's first estimate on: over a bad radio that one is
/// made of few facts, and a vehicle then drives by its start pose alone, which may be degrees off.
double Node::next_estimate_after_s() {
  const double age_s = seconds_between(begin_, now_);
  const double longest_s = std::max(settings_.estimate_s, settings_.estimate_fraction * age_s);
  const double after_s = std::min(estimate_after_s_, longest_s);
  estimate_after_s_ = 2.0 * after_s;
  return after_s;
}

void Node::report_tables(double moved_m) {
  for (Table& table : mapper_->tables(role_.durable.term, revision_, moved_m)) {
    keep(table);
    post(std::nullopt, std::move(table));
  }
}

/// The separator prior for the next round, whoever is its anchor. It is sent after the seal, with
/// further parts of the last table, exact enough to continue from.
void Node::report_separator_prior() {
  constexpr double kExact_m = 1e-3;  // of a table
  report_tables(kExact_m);
  if (!mapper_->separator()) return;
  SeparatorPrior separator = *mapper_->separator();
  separator.term = role_.durable.term;
  post(std::nullopt, std::move(separator));
}

void Node::report_map() {
  ++revision_;
  report_tables(settings_.moved_m);
  std::string waits;
  for (const VehicleFrame& frame : mapper_->last().frames) {
    if (frame.group > 0) waits += frame.waits_for;
  }
  if (waits != waits_for_ && !waits.empty()) report("fleet.unplaced", Severity::kWarning, waits);
  waits_for_ = std::move(waits);
}

std::vector<PeerState> Node::peer_state() const {
  std::vector<PeerState> out;
  const FinishSettings& finish = settings_.rounds.finish;
  const auto here = place_of(self_);
  for (const VehicleId vehicle : role_.durable.fleet) {
    const auto place = place_of(vehicle);
    if (!place) continue;
    PeerState w;
    w.vehicle = vehicle;
    w.place_map_m = place->head<2>();
    const VehicleStatus* reported = vehicle == self_ ? nullptr : &peers_.at(vehicle).status;
    w.stands = reported == nullptr || reported->mode == Mode::kHolding;
    w.at_rest = reported == nullptr ? !is_moving() : reported->at_rest;
    if (reported != nullptr) w.drive_end = reported->drive_end;
    if (const auto tag = tags_.find(vehicle); tag != tags_.end()) {
      w.stands = w.stands || forbids_driving(tag->second);
      // It has driven back since, and is not at its limit any more.
      w.no_further = tag->second == FinishReason::kDistance || tag->second == FinishReason::kSignal;
    }
    w.lost = is_lost(vehicle);
    w.stands = w.stands || w.lost;
    w.at_rest = w.at_rest || w.lost;
    if (here && vehicle != self_) {
      const double rssi_dbm = peers_.at(vehicle).status.rssi_dbm;
      w.no_further = w.no_further || (*place - *here).norm() > finish.warn_from_m() ||
                     (rssi_dbm < 0.0 && rssi_dbm < finish.rssi_stop_dbm + finish.warn_rssi_db);
    }
    out.push_back(w);
  }
  return out;
}

/// No messages for so long that it is not waited for. Its facts held by others have arrived by
/// then.
bool Node::is_lost(VehicleId vehicle) const {
  if (vehicle == self_) return false;
  const auto peer = peers_.find(vehicle);
  const Time received = peer == peers_.end() ? begin_ : peer->second.t;
  return seconds_between(received, now_) > settings_.lost_s;
}

/// No known keyframe is missing, and no vehicle is out of reach or without a frame.
bool Node::facts_are_here() const {
  const std::vector<VehicleId>& fleet = role_.durable.fleet;
  std::size_t lacking = exchange_.lacking();
  for (const VehicleId v : fleet) lacking -= is_lost(v) ? exchange_.lacking_of(v) : 0;
  return lacking == 0 && std::all_of(fleet.begin(), fleet.end(), [this](VehicleId v) {
           return v == self_ ? mapper_->is_placed(v)
                             : is_lost(v) || (mapper_->is_placed(v) && exchange_.in_reach(v, now_));
         });
}

/// Applies the result of a frontier search.
void Node::send_fleet() {
  if (!exploration_->result().mapped) return;
  note_frontiers(exploration_->input().facts_here);
  report_goals();
  if (rounds_.mission_over()) end_mission(RoundEnd::kExplored);
}

void Node::note_frontiers(bool facts_agree) {
  std::vector<VehicleId> ids;
  for (const PeerState& w : exploration_->input().fleet) ids.push_back(w.vehicle);
  rounds_.frontiers_seen(exploration_->dispatcher().frontiers(), ids, facts_agree);
}

void Node::report_goals() {
  GoalList list = exploration_->result().goals;
  list.term = role_.durable.term;
  list.revision = ++goal_revision_;
  post(std::nullopt, std::move(list));
}

void Node::end_mission(RoundEnd why) {
  done_ = true;
  rounds_.anchor_ended(why, now_);
  next_status_ = now_;
}

/// Start of the last `idle_rounds` rounds per vehicle: since then a vehicle must have reached a new
/// place. Nothing: there were not so many rounds yet.
std::optional<Time> Node::progress_since() const {
  const std::vector<RoundRow>& rows = rounds_.rounds();
  const auto count = static_cast<std::size_t>(settings_.idle_rounds *
                                              static_cast<double>(role_.durable.fleet.size()));
  if (rows.size() <= count) return std::nullopt;
  return rows[rows.size() - count].start;
}

void Node::drive() {
  if (done_ || role_.mode != RoleMode::kTag || !goals_ || must_stand(role_)) {
    // An old anchor that the new one still needs, or a vehicle that has explored its surroundings.
    return stand();
  }
  if (finish_view_.drive_back) {
    if (!backs_) go(path_back());
    backs_ = true;
    return;
  }
  backs_ = false;
  std::vector<Vec3> places;
  for (const Goal& goal : goals_->goals) {
    if (goal.vehicle == self_) places.push_back(goal.place_map_m);
  }
  if (places.empty() || !T_map_odom()) return stand();
  const bool same =
      places.size() == order_.places_map_m.size() &&
      std::equal(places.begin(), places.end(), order_.places_map_m.begin(),
                 [](const Vec3& a, const Vec3& b) { return (a - b).head<2>().norm() < 0.05; });
  if (!same) go(std::move(places));
}

void Node::stand() {
  if (!order_.places_map_m.empty()) go({});
}

void Node::go(std::vector<Vec3> places_map_m) {
  ++order_.number;
  order_.places_map_m = std::move(places_map_m);
}

std::vector<Vec3> Node::path_back() const {
  const auto T = T_map_odom();
  if (!T || trail_odom_m_.empty()) return {};
  const Vec3 here = trail_odom_m_.back();
  for (auto p = trail_odom_m_.rbegin(); p != trail_odom_m_.rend(); ++p) {
    if ((*p - here).norm() >= settings_.back_m) return {*T * *p};
  }
  return {*T * trail_odom_m_.front()};
}

}  // namespace rali::fleet
