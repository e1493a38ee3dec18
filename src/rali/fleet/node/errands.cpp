#include "rali/fleet/node/errands.hpp"

#include <algorithm>
#include <utility>

namespace rali::fleet {

using geometry::Vec2;
using map::FrontierState;

namespace {

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
  passed_.clear();
}

bool Errands::picture(const Survey& survey) {
  Result<map::CellMap> picture = survey.grid().picture();
  if (!picture) return false;
  map_ = std::move(*picture);
  passable_ = map::passable_cells(map_, settings_.frontiers.radius_m);
  return true;
}

void Errands::find(std::span<const Whereabouts> fleet) {
  std::vector<map::PathField> fields;
  fields.reserve(fleet.size());
  for (const Whereabouts& w : fleet) fields.emplace_back(map_, passable_, w.place_map_m);
  frontiers_ = map::find_frontiers(map_, passable_, fields, settings_.frontiers);
  book_.name(frontiers_);
}

bool Errands::look(const Survey& survey, std::span<const Whereabouts> fleet,
                   std::optional<std::size_t> anchor, Time now) {
  if (!picture(survey)) return false;
  find(fleet);
  settle(fleet, now);
  send(survey, fleet, anchor, now);
  return true;
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
  const double rests_s = seconds_between(std::max(errand.moved, errand.since), now);
  const bool there = (at.place_map_m - goal).norm() <= settings_.arrive_m;
  if (there && at.at_rest && rests_s >= settings_.look_s) {
    book_.visited(errand.frontier_map_m);
    if (errand.passes) passed_.push_back(errand.vehicle);
    return true;
  }
  if (rests_s >= settings_.stuck_s) {
    book_.visited(errand.frontier_map_m);
    missed_.push_back(errand.frontier_map_m);
    return true;
  }
  // Seen from afar: nothing unknown is left where it was going.
  return std::none_of(frontiers_.begin(), frontiers_.end(), [&](const map::FrontierArea& f) {
    return f.state == FrontierState::kOpen &&
           (f.centre_map_m - errand.frontier_map_m).norm() <= settings_.taken_m;
  });
}

FrontierSpot Errands::spot(std::size_t k) const {
  return {frontiers_[k].id, frontiers_[k].centre_map_m, frontiers_[k].size};
}

/// Open ones that nobody drives to and nobody has missed.
std::vector<std::size_t> Errands::free_frontiers() const {
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < frontiers_.size(); ++k) {
    if (frontiers_[k].state != FrontierState::kOpen) continue;
    const Vec2& centre = frontiers_[k].centre_map_m;
    const bool taken = std::any_of(errands_.begin(), errands_.end(), [&](const Errand& e) {
      return (e.frontier_map_m - centre).norm() <= settings_.taken_m;
    });
    const bool missed = std::any_of(missed_.begin(), missed_.end(), [&](const Vec2& p) {
      return (p - centre).norm() <= settings_.frontiers.visit_m;
    });
    if (!taken && !missed) out.push_back(k);
  }
  return out;
}

void Errands::send(const Survey& survey, std::span<const Whereabouts> fleet,
                   std::optional<std::size_t> anchor, Time now) {
  std::vector<Traveller> travellers;
  bool any = false;
  for (const Whereabouts& w : fleet) {
    Traveller t{w.vehicle, w.place_map_m, w.stands, false, w.no_further};
    t.passed = std::find(passed_.begin(), passed_.end(), w.vehicle) != passed_.end();
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
  const std::vector<std::size_t> open = free_frontiers();
  if (!any || open.empty()) return;
  std::vector<FrontierSpot> spots;
  for (const std::size_t k : open) spots.push_back(spot(k));
  const std::optional<std::size_t> first = anchor ? std::optional<std::size_t>(0) : std::nullopt;
  const GoalPlan plan = plan_goals(travellers, first, spots, map_, passable_, survey.blind_axis(),
                                   settings_.rounds.anchor, settings_.rounds.goals);
  for (const PlannedGoal& goal : plan.goals) {
    if (!goal.frontier || goal.path_map_m.size() < 2) continue;
    Errand errand;
    errand.vehicle = goal.vehicle;
    errand.frontier = spots[*goal.frontier].id;
    errand.frontier_map_m = spots[*goal.frontier].centre_map_m;
    errand.passes = goal.passes && anchor.has_value();
    errand.places_map_m = {goal.path_map_m.back()};
    if (errand.passes) {
      errand.places_map_m = via_and_end(goal.path_map_m, fleet[*anchor].place_map_m);
    }
    errand.since = errand.moved = now;
    errands_.push_back(std::move(errand));
  }
}

std::optional<std::uint32_t> Errands::largest() const {
  const map::FrontierArea* best = nullptr;
  for (const map::FrontierArea& f : frontiers_) {
    if (f.state != FrontierState::kOpen) continue;
    if (best == nullptr || f.size > best->size) best = &f;
  }
  return best != nullptr ? std::optional(best->id) : std::nullopt;
}

std::vector<VehicleId> Errands::next_anchors(const Survey& survey,
                                             std::span<const Whereabouts> fleet) const {
  std::vector<FrontierSpot> spots;
  for (std::size_t k = 0; k < frontiers_.size(); ++k) {
    if (frontiers_[k].state == FrontierState::kOpen) spots.push_back(spot(k));
  }
  std::vector<AnchorCandidate> candidates;
  std::vector<Traveller> travellers;
  for (const Whereabouts& w : fleet) {
    candidates.push_back({w.vehicle, w.place_map_m});
    travellers.push_back({w.vehicle, w.place_map_m, false, false, false});
  }
  // The ways of the next round as if links held all along: which anchor makes them hold is asked.
  GoalSettings free = settings_.rounds.goals;
  free.link_min = 0.0;
  const BlindAxisAt axis = survey.blind_axis();
  const GoalPlan plan = plan_goals(travellers, std::nullopt, spots, map_, passable_, axis,
                                   settings_.rounds.anchor, free);
  std::vector<PredictedPlace> predicted;
  for (const PlannedGoal& goal : plan.goals) {
    const auto places = predict_places(goal.path_map_m, axis, settings_.rounds.anchor.spacing_m);
    predicted.insert(predicted.end(), places.begin(), places.end());
  }
  // Everybody stands until there is an anchor again: candidates are judged where they are.
  AnchorSettings here = settings_.rounds.anchor;
  here.near_m = 0.0;
  std::vector<VehicleId> out;
  for (const RankedAnchor& r : rank_anchors(candidates, spots, predicted, map_, passable_, here)) {
    out.push_back(r.vehicle);
  }
  return out;
}

GoalList Errands::goals(const Survey& survey) const {
  GoalList list;
  std::vector<std::uint32_t> ids;
  for (const map::FrontierArea& f : frontiers_) {
    if (f.state != FrontierState::kOpen) continue;
    ids.push_back(f.id);
    list.frontiers.push_back(
        {{f.centre_map_m.x(), f.centre_map_m.y(), survey.height_m(f.centre_map_m)}, f.size});
  }
  for (const Errand& e : errands_) {
    const auto at = std::find(ids.begin(), ids.end(), e.frontier);
    for (const Vec2& p : e.places_map_m) {
      Goal goal;
      goal.vehicle = e.vehicle;
      goal.place_map_m = {p.x(), p.y(), survey.height_m(p)};
      if (at != ids.end()) goal.frontier = static_cast<std::uint32_t>(at - ids.begin());
      list.goals.push_back(goal);
    }
  }
  return list;
}

}  // namespace rali::fleet
