#include "rali/fleet/rounds/goals.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "rali/fleet/rounds/assignment.hpp"

namespace rali::fleet {
namespace {

using geometry::Vec2;

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr double kPassed_m = 1.0;   ///< both ends are this much farther away
constexpr double kCutMin_m = 1.0;   ///< shorter paths are not worth driving
constexpr double kCutCost_m = 1e4;  ///< paths that need no cut are preferred
constexpr int kVia = 16;            ///< places beside the anchor that are evaluated

double distance_to_piece(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 ab = b - a;
  const double squared = ab.squaredNorm();
  const double u = squared > 0.0 ? std::clamp((p - a).dot(ab) / squared, 0.0, 1.0) : 0.0;
  return (p - a - u * ab).norm();
}

/// The path without its last `back_m`.
std::vector<Vec2> shortened(std::vector<Vec2> path, double back_m) {
  while (path.size() > 1) {
    const Vec2 piece = path.back() - path[path.size() - 2];
    const double length_m = piece.norm();
    if (length_m > back_m) {
      path.back() -= back_m / length_m * piece;
      break;
    }
    back_m -= length_m;
    path.pop_back();
  }
  return path;
}

class Planner {
 public:
  Planner(std::span<const Traveller> travellers, std::optional<std::size_t> anchor,
          std::span<const FrontierSpot> frontiers, const map::CellMap& map,
          const std::vector<std::uint8_t>& passable, const DegenerateAxisAt& degenerate_axis,
          const AnchorSettings& links, const GoalSettings& settings)
      : travellers_(travellers),
        anchor_(anchor),
        frontiers_(frontiers),
        map_(map),
        passable_(passable),
        degenerate_axis_(degenerate_axis),
        links_(links),
        settings_(settings) {
    wide_ = open_ = passable_;
    for (const Traveller& t : travellers_) {
      if (!t.stands) continue;
      map::close_around(map_, t.place_map_m, settings_.beside_m, passable_);
      map::close_around(map_, t.place_map_m, settings_.around_m, wide_);
    }
  }

  [[nodiscard]] GoalPlan plan() {
    std::vector<std::size_t> movers;
    CostTable table;
    table.columns = frontiers_.size();
    std::vector<PlannedGoal> options;
    for (std::size_t i = 0; i < travellers_.size(); ++i) {
      if (travellers_[i].stands) continue;
      movers.push_back(i);
      const map::PathField field(map_, cells_of(travellers_[i]), travellers_[i].place_map_m);
      const std::vector<std::size_t>& missed = travellers_[i].missed;
      std::optional<map::PathField> open;
      for (std::size_t k = 0; k < frontiers_.size(); ++k) {
        const bool again = std::find(missed.begin(), missed.end(), k) != missed.end();
        options.push_back(again ? PlannedGoal{} : path(i, k, field));
        if (!again && options.back().reach == Reach::kNoPath) {
          if (!open) open.emplace(map_, open_, travellers_[i].place_map_m);
          options.back() = behind_others(i, k, *open);
        }
        table.cost.push_back(cost_of(options.back(), frontiers_[k]));
      }
    }
    table.rows = movers.size();
    const auto chosen = assign(table);
    GoalPlan out;
    out.reach.assign(frontiers_.size(), Reach::kNoPath);
    for (std::size_t n = 0; n < options.size(); ++n) {
      Reach& best = out.reach[n % frontiers_.size()];
      best = std::max(best, options[n].reach);
    }
    for (const Traveller& t : travellers_) {
      out.goals.push_back({t.vehicle, {}, {}, 0.0, Reach::kNoPath, false});
    }
    for (std::size_t row = 0; row < movers.size(); ++row) {
      if (!chosen[row]) continue;
      PlannedGoal& goal = options[row * frontiers_.size() + *chosen[row]];
      for (const PredictedLandmark& q :
           predict_places(goal.path_map_m, degenerate_axis_, links_.spacing_m)) {
        if (q.degenerate_axis) out.link_min = std::min(out.link_min, link_at(q.place_map_m));
      }
      out.goals[movers[row]] = std::move(goal);
    }
    return out;
  }

 private:
  [[nodiscard]] const std::vector<std::uint8_t>& cells_of(const Traveller& traveller) const {
    return traveller.wide ? wide_ : passable_;
  }

  [[nodiscard]] double cost_of(const PlannedGoal& goal, const FrontierSpot& f) const {
    if (goal.path_map_m.size() < 2) return kFar;
    return goal.path_m - settings_.size_weight * f.size + (goal.is_cut() ? kCutCost_m : 0.0);
  }

  /// The path over the cells of a field, if there is one.
  [[nodiscard]] PlannedGoal path_over(std::size_t i, std::size_t k,
                                      const map::PathField& field) const {
    PlannedGoal goal;
    goal.vehicle = travellers_[i].vehicle;
    goal.frontier = k;
    std::vector<Vec2> path = field.path_to(map_.cell_at(frontiers_[k].centre_map_m));
    if (path.size() < 2) return goal;
    goal.path_map_m = std::move(path);
    goal.reach = Reach::kThere;
    return goal;
  }

  [[nodiscard]] PlannedGoal path(std::size_t i, std::size_t k, const map::PathField& field) const {
    PlannedGoal goal = path_over(i, k, field);
    if (goal.reach == Reach::kNoPath) return goal;
    goal.path_map_m = shortened(std::move(goal.path_map_m), settings_.frontier_back_m);
    lead_past(i, k, field, goal);
    cut(travellers_[i], goal);
    goal.path_m = length_of(goal.path_map_m);
    return goal;
  }

  /// Where vehicles block every path: up to around_m before the first of them.
  [[nodiscard]] PlannedGoal behind_others(std::size_t i, std::size_t k,
                                          const map::PathField& open) const {
    PlannedGoal goal = path_over(i, k, open);
    if (goal.reach == Reach::kNoPath) return goal;
    double free_m = 0.0;
    for (const PredictedLandmark& q : predict_places(goal.path_map_m, {}, map_.cell_m)) {
      if (nearest_stander_m(q.place_map_m) < settings_.around_m) break;
      free_m += map_.cell_m;
    }
    const double total_m = length_of(goal.path_map_m);
    goal.path_map_m = shortened(std::move(goal.path_map_m), std::max(0.0, total_m - free_m));
    cut(travellers_[i], goal);
    goal.reach = Reach::kBlocked;
    goal.path_m = length_of(goal.path_map_m);
    if (goal.path_m < kCutMin_m) goal.path_map_m.clear();
    return goal;
  }

  [[nodiscard]] double nearest_stander_m(const Vec2& place) const {
    double nearest_m = kFar;
    for (const Traveller& t : travellers_) {
      if (t.stands) nearest_m = std::min(nearest_m, (t.place_map_m - place).norm());
    }
    return nearest_m;
  }

  void lead_past(std::size_t i, std::size_t k, const map::PathField& field,
                 PlannedGoal& goal) const {
    if (!anchor_ || !settings_.pass_anchor || travellers_[i].passed) return;
    const Vec2 anchor = travellers_[*anchor_].place_map_m;
    goal.passes = leads_past(goal.path_map_m, anchor, settings_.passed_m);
    if (goal.passes) return;
    const double direct_m = length_of(goal.path_map_m);
    double min_m = direct_m + settings_.pass_detour_m;
    for (int v = 0; v < kVia; ++v) {
      const double angle = 2.0 * 3.14159265358979323846 * v / kVia;
      const Vec2 via = anchor + settings_.pass_side_m * Vec2(std::cos(angle), std::sin(angle));
      const auto cell = map_.cell_at(via);
      if (!(field.length_m(cell) < min_m)) continue;
      const map::PathField onward(map_, cells_of(travellers_[i]), via);
      std::vector<Vec2> path = field.path_to(cell);
      const auto rest = shortened(onward.path_to(map_.cell_at(frontiers_[k].centre_map_m)),
                                  settings_.frontier_back_m);
      if (rest.size() < 2) continue;
      path.insert(path.end(), rest.begin() + 1, rest.end());
      const double length_m = length_of(path);
      if (!(length_m < min_m) || !leads_past(path, anchor, settings_.passed_m)) continue;
      min_m = length_m;
      goal.path_map_m = std::move(path);
      goal.passes = true;
    }
  }

  /// Cuts the path before the first place that needs a link and has none.
  void cut(const Traveller& traveller, PlannedGoal& goal) const {
    const auto places = predict_places(goal.path_map_m, degenerate_axis_, links_.spacing_m);
    double good_m = 0.0, at_m = 0.0;
    const double total_m = length_of(goal.path_map_m);
    for (const PredictedLandmark& q : places) {
      at_m = std::min(at_m + links_.spacing_m, total_m);
      const bool linked = !q.degenerate_axis || link_at(q.place_map_m) >= settings_.link_min;
      if (!linked) goal.reach = Reach::kNoLink;
      if (leaves(traveller, q.place_map_m)) goal.reach = Reach::kTooFar;
      if (goal.is_cut()) break;
      good_m = at_m;
    }
    if (good_m >= total_m - 1e-9) return;
    goal.path_map_m = shortened(std::move(goal.path_map_m), total_m - good_m);
    if (length_of(goal.path_map_m) < kCutMin_m) goal.path_map_m.clear();
  }

  [[nodiscard]] bool leaves(const Traveller& traveller, const Vec2& place) const {
    if (!traveller.no_further || !anchor_) return false;
    const Vec2 anchor = travellers_[*anchor_].place_map_m;
    return (place - anchor).norm() > (traveller.place_map_m - anchor).norm() + 0.1;
  }

  [[nodiscard]] double link_at(const Vec2& place) const {
    double best = 0.0;
    for (const Traveller& t : travellers_) {
      if (!t.stands) continue;
      const double link = link_chance((t.place_map_m - place).norm(), links_);
      if (link > best)
        best = std::max(best, link * map::sight_fraction(map_, t.place_map_m, place));
    }
    return best;
  }

  std::span<const Traveller> travellers_;
  std::optional<std::size_t> anchor_;
  std::span<const FrontierSpot> frontiers_;
  const map::CellMap& map_;
  std::vector<std::uint8_t> passable_;  ///< without the surroundings of vehicles at standstill
  std::vector<std::uint8_t> wide_;      ///< likewise, with around_m
  std::vector<std::uint8_t> open_;      ///< ignoring all vehicles
  const DegenerateAxisAt& degenerate_axis_;
  const AnchorSettings& links_;
  const GoalSettings& settings_;
};

}  // namespace

std::string_view reason_of(Reach reach) {
  switch (reach) {
    case Reach::kNoPath:
      return "no vehicle that can drive has a path to it";
    case Reach::kBlocked:
      return "another vehicle blocks every path to it";
    case Reach::kTooFar:
      return "it is farther from the anchor than a vehicle may go";
    case Reach::kNoLink:
      return "no range to a vehicle at standstill arrives on the path, where the LiDAR is "
             "degenerate";
    case Reach::kThere:
      return "a path leads there, but no drive arrived";
  }
  return {};
}

double length_of(std::span<const Vec2> path_map_m) {
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < path_map_m.size(); ++i) {
    sum += (path_map_m[i + 1] - path_map_m[i]).norm();
  }
  return sum;
}

bool is_passage(double first_m, double min_m, double last_m, double near_m) {
  return min_m <= near_m && std::min(first_m, last_m) >= min_m + kPassed_m;
}

bool leads_past(std::span<const Vec2> path_map_m, const Vec2& place_map_m, double near_m) {
  if (path_map_m.size() < 2) return false;
  double nearest = kFar;
  for (std::size_t i = 0; i + 1 < path_map_m.size(); ++i) {
    nearest = std::min(nearest, distance_to_piece(place_map_m, path_map_m[i], path_map_m[i + 1]));
  }
  const double start_m = (path_map_m.front() - place_map_m).norm();
  const double end_m = (path_map_m.back() - place_map_m).norm();
  return is_passage(start_m, nearest, end_m, near_m);
}

GoalPlan plan_goals(std::span<const Traveller> travellers, std::optional<std::size_t> anchor,
                    std::span<const FrontierSpot> frontiers, const map::CellMap& map,
                    const std::vector<std::uint8_t>& passable,
                    const DegenerateAxisAt& degenerate_axis, const AnchorSettings& links,
                    const GoalSettings& settings) {
  return Planner(travellers, anchor, frontiers, map, passable, degenerate_axis, links, settings)
      .plan();
}

}  // namespace rali::fleet
