#include "rali/fleet/node/errands.hpp"

#include <algorithm>
#include <utility>

namespace rali::fleet {

using geometry::Vec2;
using map::FrontierState;

namespace {

constexpr double kSameGoal_m = 0.05;  ///< as Node::drive() has it

AnchorUse use_of(const GoalPlan& plan) {
  AnchorUse use = AnchorUse::kNone;
  for (const PlannedGoal& goal : plan.goals) {
    if (goal.path_map_m.size() < 2) continue;
    use = std::max(use, goal.reach == Reach::kBlocked ? AnchorUse::kCloseUp : AnchorUse::kExplore);
  }
  return use;
}

/// The point of a way nearest to a place, and the way's end.
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

void Errands::new_round() {
  errands_.clear();
  missed_.clear();
  shut_off_.clear();
  not_past_.clear();
  passages_.clear();
}

/// There is no way to where one stands already, and nobody is sent there.
void Errands::note_who_stands(std::span<const Whereabouts> fleet) {
  for (const map::FrontierArea& f : frontiers_) {
    const bool there = std::any_of(fleet.begin(), fleet.end(), [&](const Whereabouts& w) {
      return w.at_rest && (w.place_map_m - f.centre_map_m).norm() <= settings_.arrive_m;
    });
    if (there) book_.visited(f.centre_map_m);
  }
  book_.name(frontiers_);
}

bool Errands::take_picture(const ExploreMap& explored) {
  Result<map::CellMap> cells = explored.grid().picture();
  if (!cells) return false;
  auto picture = std::make_shared<Picture>();
  picture->map = std::move(*cells);
  picture->passable = map::passable_cells(picture->map, settings_.frontiers.radius_m);
  picture_ = std::move(picture);
  return true;
}

void Errands::find(std::span<const Whereabouts> fleet) {
  std::vector<map::PathField> fields;
  fields.reserve(fleet.size());
  for (const Whereabouts& w : fleet) {
    fields.emplace_back(picture_->map, picture_->passable, w.place_map_m);
  }
  frontiers_ = map::find_frontiers(picture_->map, picture_->passable, fields, settings_.frontiers);
  book_.name(frontiers_);
  std::vector<VehicleId> vehicles;
  for (const Whereabouts& w : fleet) {
    if (!w.lost) vehicles.push_back(w.vehicle);
  }
  book_.give_up_unreached(frontiers_, vehicles);
}

bool Errands::look(const ExploreMap& explored, std::span<const Whereabouts> fleet,
                   std::optional<std::size_t> anchor, Time now) {
  if (!take_picture(explored)) return false;
  find(fleet);
  if (anchor) watch_passages(fleet, *anchor);
  settle(fleet, now);
  send(explored, fleet, anchor, now);
  return true;
}

/// Whoever has driven past the anchor has, whether the goal that led there is still one or not.
void Errands::watch_passages(std::span<const Whereabouts> fleet, std::size_t anchor) {
  for (const Whereabouts& w : fleet) {
    const double d = (w.place_map_m - fleet[anchor].place_map_m).norm();
    Passage& passage = passages_.try_emplace(w.vehicle, Passage{d, d, d}).first->second;
    passage.least_m = std::min(passage.least_m, d);
    passage.last_m = d;
  }
}

bool Errands::has_passed(VehicleId vehicle) const {
  const auto at = passages_.find(vehicle);
  if (at == passages_.end()) return false;
  const Passage& p = at->second;
  return is_passage(p.first_m, p.least_m, p.last_m, settings_.rounds.goals.passed_m);
}

void Errands::settle(std::span<const Whereabouts> fleet, Time now) {
  std::erase_if(errands_, [&](Errand& errand) {
    const auto at = std::find_if(fleet.begin(), fleet.end(),
                                 [&](const Whereabouts& w) { return w.vehicle == errand.vehicle; });
    return at == fleet.end() || at->stands || settled(errand, *at, now);
  });
}

bool Errands::settled(Errand& errand, const Whereabouts& at, Time now) {
  if (!at.at_rest) errand.moved = now;
  const Vec2& goal = errand.places_map_m.back();
  if (at.drive_end && (at.drive_end->goal_map_m.head<2>() - goal).norm() <= kSameGoal_m) {
    if (at.drive_end->state != DriveState::kArrived) {
      gave_up(errand, at.drive_end->state);
      return true;
    }
    // Its keyframe from there has to arrive first.
    const double rests_s = seconds_between(std::max(errand.moved, errand.since), now);
    if (!at.at_rest || rests_s < settings_.look_s) return false;
    arrived(errand);
    return true;
  }
  // Seen from afar: nothing unknown is left where it was going.
  return std::none_of(frontiers_.begin(), frontiers_.end(), [&](const map::FrontierArea& f) {
    return f.state == FrontierState::kOpen &&
           (f.centre_map_m - errand.frontier_map_m).norm() <= settings_.taken_m;
  });
}

/// At the frontier, or as near to it as it may come in this round.
void Errands::arrived(const Errand& errand) {
  if (errand.cut) {
    missed_.emplace_back(errand.vehicle, errand.frontier_map_m);
  } else {
    book_.visited(errand.frontier_map_m);
  }
}

/// Another vehicle in the path leaves in a later round; a path that does not exist never will. A
/// place beside the anchor that cannot be reached says nothing about the frontier.
void Errands::gave_up(const Errand& errand, DriveState state) {
  if (state == DriveState::kUnreachable) {
    if (errand.places_map_m.size() > 1) {
      not_past_.insert(errand.vehicle);
      return;
    }
    book_.found_no_path(errand.vehicle, errand.frontier_map_m);
    return;
  }
  shut_off_.insert(errand.vehicle);
  missed_.emplace_back(errand.vehicle, errand.frontier_map_m);
}

std::vector<std::size_t> Errands::open_frontiers() const {
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < frontiers_.size(); ++k) {
    if (frontiers_[k].state == FrontierState::kOpen) out.push_back(k);
  }
  return out;
}

/// Open ones that nobody drives to.
std::vector<std::size_t> Errands::free_frontiers() const {
  std::vector<std::size_t> out = open_frontiers();
  std::erase_if(out, [this](std::size_t k) {
    return std::any_of(errands_.begin(), errands_.end(), [&](const Errand& e) {
      return (e.frontier_map_m - frontiers_[k].centre_map_m).norm() <= settings_.taken_m;
    });
  });
  return out;
}

std::vector<FrontierSpot> Errands::spots_of(const std::vector<std::size_t>& which) const {
  std::vector<FrontierSpot> spots;
  for (const std::size_t k : which) {
    spots.push_back({frontiers_[k].id, frontiers_[k].centre_map_m, frontiers_[k].size});
  }
  return spots;
}

std::vector<std::size_t> Errands::missed_by(VehicleId vehicle, std::span<const FrontierSpot> spots,
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

void Errands::send(const ExploreMap& explored, std::span<const Whereabouts> fleet,
                   std::optional<std::size_t> anchor, Time now) {
  const std::vector<FrontierSpot> spots = spots_of(free_frontiers());
  std::vector<Traveller> travellers;
  bool any = false;
  for (const Whereabouts& w : fleet) {
    const bool direct = has_passed(w.vehicle) || not_past_.contains(w.vehicle);
    Traveller t{w.vehicle, w.place_map_m, w.stands, direct, w.no_further};
    t.wide = shut_off_.contains(w.vehicle);
    t.missed = missed_by(w.vehicle, spots, true);
    const bool busy = std::any_of(errands_.begin(), errands_.end(),
                                  [&](const Errand& e) { return e.vehicle == w.vehicle; });
    any = any || (!w.stands && !busy);
    // Whoever is on its way keeps its goal, and does not stand there for others to range to.
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
      plan_goals(travellers, first, spots, picture_->map, picture_->passable, explored.blind_axis(),
                 settings_.rounds.anchor, settings_.rounds.goals);
  for (const PlannedGoal& goal : plan.goals) {
    if (!goal.frontier || goal.path_map_m.size() < 2) continue;
    errands_.push_back(errand_of(goal, spots[*goal.frontier], fleet, anchor, now));
  }
}

Errands::Errand Errands::errand_of(const PlannedGoal& goal, const FrontierSpot& frontier,
                                   std::span<const Whereabouts> fleet,
                                   std::optional<std::size_t> anchor, Time now) const {
  Errand errand;
  errand.vehicle = goal.vehicle;
  errand.frontier = frontier.id;
  errand.frontier_map_m = frontier.centre_map_m;
  errand.cut = goal.is_cut();
  errand.places_map_m = {goal.path_map_m.back()};
  if (goal.passes && anchor) {
    errand.places_map_m = via_and_end(goal.path_map_m, fleet[*anchor].place_map_m);
  }
  errand.since = errand.moved = now;
  return errand;
}

std::optional<std::uint32_t> Errands::largest() const {
  const map::FrontierArea* best = nullptr;
  for (const map::FrontierArea& f : frontiers_) {
    if (f.state != FrontierState::kOpen) continue;
    if (best == nullptr || f.size > best->size) best = &f;
  }
  return best != nullptr ? std::optional(best->id) : std::nullopt;
}

/// The goals of the others while one of the fleet stands as anchor.
GoalPlan Errands::round_of(std::size_t anchor, std::span<const Whereabouts> fleet,
                           std::span<const FrontierSpot> spots, const BlindAxisAt& axis,
                           bool missed_counts, double link_min) const {
  std::vector<Traveller> travellers;
  for (std::size_t i = 0; i < fleet.size(); ++i) {
    const Whereabouts& w = fleet[i];
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

/// The paper's choice knows no links.
double Errands::link_min() const {
  const RoundSettings& rounds = settings_.rounds;
  return rounds.anchor.choice == AnchorChoice::kPaper ? 0.0 : rounds.goals.link_min;
}

std::vector<VehicleId> Errands::next_anchors(const ExploreMap& explored,
                                             std::span<const Whereabouts> fleet,
                                             VehicleId anchor) const {
  const std::vector<FrontierSpot> spots = spots_of(open_frontiers());
  const BlindAxisAt axis = explored.blind_axis();
  // Everybody stands until there is an anchor again: candidates are judged where they are.
  AnchorSettings here = settings_.rounds.anchor;
  here.near_m = 0.0;
  std::vector<AnchorOption> options;
  for (std::size_t i = 0; i < fleet.size(); ++i) {
    if (fleet[i].lost) continue;
    const bool missed_counts = fleet[i].vehicle == anchor;
    AnchorOption option;
    option.candidate = {fleet[i].vehicle, fleet[i].place_map_m};
    option.use = use_of(round_of(i, fleet, spots, axis, missed_counts, link_min()));
    // What it is worth is asked as if links held all along: which anchor makes them hold?
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

std::vector<Errands::Stop> Errands::stops(const ExploreMap& explored,
                                          std::span<const Whereabouts> fleet,
                                          VehicleId anchor) const {
  const std::vector<FrontierSpot> spots = spots_of(open_frontiers());
  std::vector<Stop> out;
  for (const FrontierSpot& spot : spots) out.push_back({spot.id, Reach::kNoPath});
  for (std::size_t i = 0; i < fleet.size(); ++i) {
    if (fleet[i].lost) continue;
    const bool missed_counts = fleet[i].vehicle == anchor;
    const GoalPlan plan =
        round_of(i, fleet, spots, explored.blind_axis(), missed_counts, link_min());
    for (std::size_t k = 0; k < out.size(); ++k) {
      out[k].reach = std::max(out[k].reach, plan.reach[k]);
    }
  }
  return out;
}

GoalList Errands::goals(const ExploreMap& explored) const {
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
  for (const Errand& e : errands_) {
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
