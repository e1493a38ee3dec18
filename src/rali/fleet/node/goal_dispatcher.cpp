#include "rali/fleet/node/goal_dispatcher.hpp"

#include <algorithm>
#include <utility>

namespace rali::fleet {

using geometry::Vec2;
using map::FrontierState;

namespace {

constexpr double kSameGoal_m = 0.05;  ///< as in Node::drive()

AnchorUse use_of(const GoalPlan& plan) {
  AnchorUse use = AnchorUse::kNone;
  for (const PlannedGoal& goal : plan.goals) {
    if (goal.path_map_m.size() < 2) continue;
    use = std::max(use, goal.reach == Reach::kBlocked ? AnchorUse::kCloseUp : AnchorUse::kExplore);
  }
  return use;
}

/// The point of a path nearest to a place, and the path's end.
std::vector<Vec2> via_and_end(const std::vector<Vec2>& path, const Vec2& place) {
  Vec2 via = path.front();
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const Vec2 ab = path[i + 1] - path[i];
    const double squared = ab.squaredNorm();
    const double u =
        squared > 0.0 ? std::clamp((place - path[i]).dot(ab) / squared, 0.0, 1.0) : 0.0;
    const Vec2 q = path[i] + u * ab;
    if ((q - place).norm() < (via - place).norm()) via = q;
  }
  return {via, path.back()};
}

}  // namespace

void GoalDispatcher::new_round() {
  tasks_.clear();
  missed_.clear();
  shut_off_.clear();
  not_past_.clear();
  passages_.clear();
}

/// There is no path to the vehicle's own place, so no vehicle is sent there.
void GoalDispatcher::note_who_stands(std::span<const PeerState> fleet) {
  for (const map::FrontierArea& f : frontiers_) {
    const bool there = std::any_of(fleet.begin(), fleet.end(), [&](const PeerState& w) {
      return w.at_rest && (w.place_map_m - f.centre_map_m).norm() <= settings_.arrive_m;
    });
    if (there) book_.visited(f.centre_map_m);
  }
  book_.name(frontiers_);
}

bool GoalDispatcher::take_picture(const ExploreMap& explored) {
  Result<map::CellMap> cells = explored.grid().picture();
  if (!cells) return false;
  auto picture = std::make_shared<Picture>();
  picture->map = std::move(*cells);
  picture->passable = map::passable_cells(picture->map, settings_.frontiers.radius_m);
  picture_ = std::move(picture);
  return true;
}

void GoalDispatcher::find(std::span<const PeerState> fleet) {
  std::vector<map::PathField> fields;
  fields.reserve(fleet.size());
  for (const PeerState& w : fleet) {
    fields.emplace_back(picture_->map, picture_->passable, w.place_map_m);
  }
  frontiers_ = map::find_frontiers(picture_->map, picture_->passable, fields, settings_.frontiers);
  book_.name(frontiers_);
  std::vector<VehicleId> vehicles;
  for (const PeerState& w : fleet) {
    if (!w.lost) vehicles.push_back(w.vehicle);
  }
  book_.give_up_unreached(frontiers_, vehicles);
}

bool GoalDispatcher::look(const ExploreMap& explored, std::span<const PeerState> fleet,
                          std::optional<std::size_t> anchor, Time now) {
  if (!take_picture(explored)) return false;
  find(fleet);
  if (anchor) watch_passages(fleet, *anchor);
  settle(fleet, now);
  send(explored, fleet, anchor, now);
  return true;
}

/// A vehicle that has passed the anchor stays so, even if the goal of that path has ended.
void GoalDispatcher::watch_passages(std::span<const PeerState> fleet, std::size_t anchor) {
  for (const PeerState& w : fleet) {
    const double d = (w.place_map_m - fleet[anchor].place_map_m).norm();
    Passage& passage = passages_.try_emplace(w.vehicle, Passage{d, d, d}).first->second;
    passage.min_m = std::min(passage.min_m, d);
    passage.last_m = d;
  }
}

bool GoalDispatcher::has_passed(VehicleId vehicle) const {
  const auto at = passages_.find(vehicle);
  if (at == passages_.end()) return false;
  const Passage& p = at->second;
  return is_passage(p.first_m, p.min_m, p.last_m, settings_.rounds.goals.passed_m);
}

void GoalDispatcher::settle(std::span<const PeerState> fleet, Time now) {
  std::erase_if(tasks_, [&](GoalTask& task) {
    const auto at = std::find_if(fleet.begin(), fleet.end(),
                                 [&](const PeerState& w) { return w.vehicle == task.vehicle; });
    return at == fleet.end() || at->stands || settled(task, *at, stands_beside(*at, fleet), now);
  });
}

/// Whether another vehicle may be what blocks the path of this one.
bool GoalDispatcher::stands_beside(const PeerState& vehicle,
                                   std::span<const PeerState> fleet) const {
  return std::any_of(fleet.begin(), fleet.end(), [&](const PeerState& w) {
    return w.vehicle != vehicle.vehicle && w.at_rest &&
           (w.place_map_m - vehicle.place_map_m).norm() <= settings_.rounds.goals.around_m;
  });
}

bool GoalDispatcher::settled(GoalTask& task, const PeerState& at, bool beside_another, Time now) {
  if (!at.at_rest) task.moved = now;
  const Vec2& goal = task.places_map_m.back();
  if (at.drive_end && (at.drive_end->goal_map_m.head<2>() - goal).norm() <= kSameGoal_m) {
    if (at.drive_end->state != DriveState::kArrived) {
      gave_up(task, at.drive_end->state, beside_another);
      return true;
    }
    // Its keyframe from there must arrive first.
    const double rests_s = seconds_between(std::max(task.moved, task.since), now);
    if (!at.at_rest || rests_s < settings_.look_s) return false;
    arrived(task);
    return true;
  }
  // Observed from afar: no open frontier is left near its goal.
  return std::none_of(frontiers_.begin(), frontiers_.end(), [&](const map::FrontierArea& f) {
    return f.state == FrontierState::kOpen &&
           (f.centre_map_m - task.frontier_map_m).norm() <= settings_.taken_m;
  });
}

/// It is at the frontier, or as close to it as possible in this round.
void GoalDispatcher::arrived(const GoalTask& task) {
  if (task.cut) {
    missed_.emplace_back(task.vehicle, task.frontier_map_m);
  } else {
    book_.visited(task.frontier_map_m);
  }
}

/// A vehicle that blocks the path leaves in a later round; a path that does not exist never
/// appears. An unreachable place beside the anchor gives no information on the frontier.
void GoalDispatcher::gave_up(const GoalTask& task, DriveState state, bool beside_another) {
  if (state != DriveState::kBlocked && task.places_map_m.size() > 1) {
    not_past_.insert(task.vehicle);
  } else if (state == DriveState::kUnreachable ||
             (state == DriveState::kGivenUp && !beside_another)) {
    book_.found_no_path(task.vehicle, task.frontier_map_m);
  } else {
    shut_off_.insert(task.vehicle);
    missed_.emplace_back(task.vehicle, task.frontier_map_m);
  }
}

std::vector<std::size_t> GoalDispatcher::open_frontiers() const {
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < frontiers_.size(); ++k) {
    if (frontiers_[k].state == FrontierState::kOpen) out.push_back(k);
  }
  return out;
}

/// Open ones that no vehicle is driving to.
std::vector<std::size_t> GoalDispatcher::free_frontiers() const {
  std::vector<std::size_t> out = open_frontiers();
  std::erase_if(out, [this](std::size_t k) {
    return std::any_of(tasks_.begin(), tasks_.end(), [&](const GoalTask& e) {
      return (e.frontier_map_m - frontiers_[k].centre_map_m).norm() <= settings_.taken_m;
    });
  });
  return out;
}

std::vector<FrontierSpot> GoalDispatcher::spots_of(const std::vector<std::size_t>& which) const {
  std::vector<FrontierSpot> spots;
  for (const std::size_t k : which) {
    spots.push_back({frontiers_[k].id, frontiers_[k].centre_map_m, frontiers_[k].size});
  }
  return spots;
}

std::vector<std::size_t> GoalDispatcher::missed_by(VehicleId vehicle,
                                                   std::span<const FrontierSpot> spots,
                                                   bool in_this_round) const {
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < spots.size(); ++k) {
    const Vec2& centre = spots[k].centre_map_m;
    const bool missed = std::any_of(missed_.begin(), missed_.end(), [&](const auto& m) {
      return m.first == vehicle && (m.second - centre).norm() <= settings_.frontiers.visit_m;
    });
    if ((in_this_round && missed) || book_.has_no_path(vehicle, centre)) out.push_back(k);
  }
  return out;
}

void GoalDispatcher::send(const ExploreMap& explored, std::span<const PeerState> fleet,
                          std::optional<std::size_t> anchor, Time now) {
  const std::vector<FrontierSpot> spots = spots_of(free_frontiers());
  std::vector<Traveller> travellers;
  bool any = false;
  for (const PeerState& w : fleet) {
    const bool direct = has_passed(w.vehicle) || not_past_.contains(w.vehicle);
    Traveller t{w.vehicle, w.place_map_m, w.stands, direct, w.no_further};
    t.wide = shut_off_.contains(w.vehicle);
    t.missed = missed_by(w.vehicle, spots, true);
    const bool busy = std::any_of(tasks_.begin(), tasks_.end(),
                                  [&](const GoalTask& e) { return e.vehicle == w.vehicle; });
    any = any || (!w.stands && !busy);
    // A vehicle that drives keeps its goal, and is no standing range partner for others.
    if (busy) continue;
    if (anchor && w.vehicle == fleet[*anchor].vehicle) {
      t.stands = true;
      travellers.insert(travellers.begin(), t);
    } else {
      travellers.push_back(t);
    }
  }
  if (!any || spots.empty()) return;
  const std::optional<std::size_t> first = anchor ? std::optional<std::size_t>(0) : std::nullopt;
  const GoalPlan plan =
      plan_goals(travellers, first, spots, picture_->map, picture_->passable,
                 explored.degenerate_axis(), settings_.rounds.anchor, settings_.rounds.goals);
  for (const PlannedGoal& goal : plan.goals) {
    if (!goal.frontier || goal.path_map_m.size() < 2) continue;
    tasks_.push_back(task_of(goal, spots[*goal.frontier], fleet, anchor, now));
  }
}

GoalDispatcher::GoalTask GoalDispatcher::task_of(const PlannedGoal& goal,
                                                 const FrontierSpot& frontier,
                                                 std::span<const PeerState> fleet,
                                                 std::optional<std::size_t> anchor,
                                                 Time now) const {
  GoalTask task;
  task.vehicle = goal.vehicle;
  task.frontier = frontier.id;
  task.frontier_map_m = frontier.centre_map_m;
  task.cut = goal.is_cut();
  task.places_map_m = {goal.path_map_m.back()};
  if (goal.passes && anchor) {
    task.places_map_m = via_and_end(goal.path_map_m, fleet[*anchor].place_map_m);
  }
  task.since = task.moved = now;
  return task;
}

std::optional<std::uint32_t> GoalDispatcher::largest() const {
  const map::FrontierArea* best = nullptr;
  for (const map::FrontierArea& f : frontiers_) {
    if (f.state != FrontierState::kOpen) continue;
    if (best == nullptr || f.size > best->size) best = &f;
  }
  return best != nullptr ? std::optional(best->id) : std::nullopt;
}

/// The goals of the others while one vehicle of the fleet is the anchor.
GoalPlan GoalDispatcher::round_of(std::size_t anchor, std::span<const PeerState> fleet,
                                  std::span<const FrontierSpot> spots, const DegenerateAxisAt& axis,
                                  bool missed_counts, double link_min) const {
  std::vector<Traveller> travellers;
  for (std::size_t i = 0; i < fleet.size(); ++i) {
    const PeerState& w = fleet[i];
    const double apart_m = (w.place_map_m - fleet[anchor].place_map_m).norm();
    const bool at_edge =
        apart_m > settings_.rounds.finish.warn_from_m() || (missed_counts && w.no_further);
    Traveller t{w.vehicle, w.place_map_m, w.lost || i == anchor, true, at_edge};
    t.wide = missed_counts && shut_off_.contains(w.vehicle);
    t.missed = missed_by(w.vehicle, spots, missed_counts);
    travellers.push_back(std::move(t));
  }
  GoalSettings goals = settings_.rounds.goals;
  goals.link_min = link_min;
  return plan_goals(travellers, anchor, spots, picture_->map, picture_->passable, axis,
                    settings_.rounds.anchor, goals);
}

/// The paper's choice ignores links.
double GoalDispatcher::link_min() const {
  const RoundSettings& rounds = settings_.rounds;
  return rounds.anchor.choice == AnchorChoice::kPaper ? 0.0 : rounds.goals.link_min;
}

std::vector<VehicleId> GoalDispatcher::next_anchors(const ExploreMap& explored,
                                                    std::span<const PeerState> fleet,
                                                    VehicleId anchor) const {
  const std::vector<FrontierSpot> spots = spots_of(open_frontiers());
  const DegenerateAxisAt axis = explored.degenerate_axis();
  // All vehicles keep standstill until there is an anchor again: candidates are rated where they
  // are.
  AnchorSettings here = settings_.rounds.anchor;
  here.near_m = 0.0;
  std::vector<AnchorOption> options;
  for (std::size_t i = 0; i < fleet.size(); ++i) {
    if (fleet[i].lost) continue;
    const bool missed_counts = fleet[i].vehicle == anchor;
    AnchorOption option;
    option.candidate = {fleet[i].vehicle, fleet[i].place_map_m};
    option.use = use_of(round_of(i, fleet, spots, axis, missed_counts, link_min()));
    // The value is computed as if all links held, because it rates which anchor makes them hold.
    const GoalPlan plan = round_of(i, fleet, spots, axis, missed_counts, 0.0);
    for (const PlannedGoal& goal : plan.goals) {
      const auto places = predict_places(goal.path_map_m, axis, here.spacing_m);
      option.predicted.insert(option.predicted.end(), places.begin(), places.end());
    }
    options.push_back(std::move(option));
  }
  std::vector<VehicleId> out;
  for (const RankedAnchor& r :
       rank_anchors(options, spots, picture_->map, picture_->passable, here)) {
    out.push_back(r.vehicle);
  }
  return out;
}

std::vector<GoalDispatcher::Stop> GoalDispatcher::stops(const ExploreMap& explored,
                                                        std::span<const PeerState> fleet,
                                                        VehicleId anchor) const {
  const std::vector<FrontierSpot> spots = spots_of(open_frontiers());
  std::vector<Stop> out;
  for (const FrontierSpot& spot : spots) out.push_back({spot.id, Reach::kNoPath});
  for (std::size_t i = 0; i < fleet.size(); ++i) {
    if (fleet[i].lost) continue;
    const bool missed_counts = fleet[i].vehicle == anchor;
    const GoalPlan plan =
        round_of(i, fleet, spots, explored.degenerate_axis(), missed_counts, link_min());
    for (std::size_t k = 0; k < out.size(); ++k) {
      out[k].reach = std::max(out[k].reach, plan.reach[k]);
    }
  }
  return out;
}

GoalList GoalDispatcher::goals(const ExploreMap& explored) const {
  GoalList list;
  std::vector<std::uint32_t> ids;
  for (const map::FrontierArea& f : frontiers_) {
    if (f.state != FrontierState::kOpen) continue;
    ids.push_back(f.id);
    list.frontiers.push_back(
        {{f.centre_map_m.x(), f.centre_map_m.y(), explored.height_m(f.centre_map_m)}, f.size});
  }
  list.memory = book_.memory();
  std::erase_if(list.memory.named, [&ids](const map::NamedFrontier& named) {
    return named.visits == 0 && std::find(ids.begin(), ids.end(), named.id) == ids.end();
  });
  for (const GoalTask& e : tasks_) {
    const auto at = std::find(ids.begin(), ids.end(), e.frontier);
    for (const Vec2& p : e.places_map_m) {
      Goal goal;
      goal.vehicle = e.vehicle;
      goal.place_map_m = {p.x(), p.y(), explored.height_m(p)};
      if (at != ids.end()) goal.frontier = static_cast<std::uint32_t>(at - ids.begin());
      list.goals.push_back(goal);
    }
  }
  return list;
}

}  // namespace rali::fleet
