#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "rali/fleet/node/node.hpp"

namespace rali::fleet {

using geometry::SE3;
using geometry::Vec3;

void Node::add_new_facts() {
  for (const FactPtr& fact : store_.take_new()) {
    if (Survey* survey = any_survey()) survey->add(fact);
    if (exploration_) exploration_->add(fact);
  }
}

void Node::survey_tick() {
  if (role_.mode == RoleMode::kSealed) return offer_choice();
  if (!may_publish(role_, now_) || done_) return;
  if (now_ >= next_estimate_ && !estimating_) {
    const double age_s = seconds_between(begin_, now_);
    next_estimate_ =
        now_ + Duration::from_s(std::max(settings_.estimate_s, settings_.estimate_share * age_s));
    start_estimate(JobKind::kEstimate);
  }
  if (now_ >= next_look_ && !exploring_) {
    next_look_ = now_ + Duration::from_s(settings_.look_s);
    start_exploration(JobKind::kExplore);
  }
}

void Node::tell_tables(double moved_m) {
  for (Table& table : survey_->tables(role_.durable.term, revision_, moved_m)) {
    keep(table);
    post(std::nullopt, std::move(table));
  }
}

/// What the round leaves to the next one, whoever is its anchor. It comes after the seal: further
/// parts of the last table, exact enough to go on from.
void Node::tell_boundary() {
  constexpr double kExact_m = 1e-3;  // of a table
  tell_tables(kExact_m);
  if (!survey_->boundary()) return;
  RoundBoundary boundary = *survey_->boundary();
  boundary.term = role_.durable.term;
  post(std::nullopt, std::move(boundary));
}

void Node::tell_map() {
  ++revision_;
  tell_tables(settings_.moved_m);
  std::string waits;
  for (const VehicleFrame& frame : survey_->last().frames) {
    if (frame.group > 0) waits += frame.waits_for;
  }
  if (waits != waits_for_ && !waits.empty()) report("fleet.unplaced", Severity::kWarning, waits);
  waits_for_ = std::move(waits);
}

std::vector<Whereabouts> Node::whereabouts() const {
  std::vector<Whereabouts> out;
  const FinishSettings& finish = settings_.rounds.finish;
  const auto here = place_of(self_);
  for (const VehicleId vehicle : role_.durable.fleet) {
    const auto place = place_of(vehicle);
    if (!place) continue;
    Whereabouts w;
    w.vehicle = vehicle;
    w.place_map_m = place->head<2>();
    const VehicleStatus* told = vehicle == self_ ? nullptr : &peers_.at(vehicle).status;
    w.stands = told == nullptr || told->mode == Mode::kHolding;
    w.at_rest = told == nullptr ? !is_moving() : told->at_rest;
    if (told != nullptr) w.drive_end = told->drive_end;
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

/// Silent for so long that nobody waits for it. What others hold of its facts has come by then.
bool Node::is_lost(VehicleId vehicle) const {
  if (vehicle == self_) return false;
  const auto peer = peers_.find(vehicle);
  const Time heard = peer == peers_.end() ? begin_ : peer->second.t;
  return seconds_between(heard, now_) > settings_.lost_s;
}

/// No keyframe is known of and not there, and nobody is out of reach or without a frame.
bool Node::facts_are_here() const {
  const std::vector<VehicleId>& fleet = role_.durable.fleet;
  std::size_t lacking = exchange_.lacking();
  for (const VehicleId v : fleet) lacking -= is_lost(v) ? exchange_.lacking_of(v) : 0;
  return lacking == 0 && std::all_of(fleet.begin(), fleet.end(), [this](VehicleId v) {
           return v == self_ ? survey_->is_placed(v)
                             : is_lost(v) || (survey_->is_placed(v) && exchange_.in_reach(v, now_));
         });
}

/// What a search for frontiers has found.
void Node::send_fleet() {
  if (!exploration_->result().mapped) return;
  note_frontiers(exploration_->input().facts_here);
  tell_goals();
  if (rounds_.mission_over()) end_mission(RoundEnd::kExplored);
}

void Node::note_frontiers(bool facts_agree) {
  std::vector<VehicleId> ids;
  for (const Whereabouts& w : exploration_->input().fleet) ids.push_back(w.vehicle);
  rounds_.frontiers_seen(exploration_->errands().frontiers(), ids, facts_agree);
}

void Node::tell_goals() {
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

/// Begin of the last rounds of each vehicle in which somebody has to come to a place where nobody
/// had been; nothing: there were not so many yet.
std::optional<Time> Node::progress_since() const {
  const std::vector<RoundRow>& rows = rounds_.rounds();
  const auto count = static_cast<std::size_t>(settings_.idle_rounds *
                                              static_cast<double>(role_.durable.fleet.size()));
  if (rows.size() <= count) return std::nullopt;
  return rows[rows.size() - count].start;
}

void Node::drive() {
  if (done_ || role_.mode != RoleMode::kTag || !goals_ || must_stand(role_)) {
    // An old anchor that the new one still needs, and whoever has only seen everything.
    return stand();
  }
  if (finish_view_.drive_back) {
    if (!backs_) go(way_back());
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

std::vector<Vec3> Node::way_back() const {
  const auto T = T_map_odom();
  if (!T || trail_odom_m_.empty()) return {};
  const Vec3 here = trail_odom_m_.back();
  for (auto p = trail_odom_m_.rbegin(); p != trail_odom_m_.rend(); ++p) {
    if ((*p - here).norm() >= settings_.back_m) return {*T * *p};
  }
  return {*T * trail_odom_m_.front()};
}

}  // namespace rali::fleet
