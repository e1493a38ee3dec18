#include "rali/fleet/rounds/anchor_choice.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace rali::fleet {
namespace {

using geometry::Vec2;

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr double kLattice_m = 1.0;  ///< of the places evaluated around a vehicle
constexpr double kSame_m = 0.01;

std::optional<std::size_t> largest(std::span<const FrontierSpot> frontiers) {
  std::optional<std::size_t> best;
  for (std::size_t k = 0; k < frontiers.size(); ++k) {
    if (!best || frontiers[k].size > frontiers[*best].size) best = k;
  }
  return best;
}

/// Straight, or along the path from each candidate's position.
double distance_to(const AnchorCandidate& c, const FrontierSpot& f, const map::PathField* field,
                   const map::CellMap& map, const AnchorSettings& settings) {
  if (settings.distance == FrontierDistance::kEuclid || field == nullptr) {
    return (c.place_map_m - f.centre_map_m).norm();
  }
  return field->length_m(map.cell_at(f.centre_map_m));
}

RankedAnchor best_place(const AnchorCandidate& candidate, const map::PathField& field,
                        std::span<const PredictedLandmark> predicted, const map::CellMap& map,
                        const AnchorSettings& settings) {
  RankedAnchor best{candidate.vehicle, candidate.place_map_m, 0.0, 0.0, 0.0};
  best.value = anchor_value(candidate.place_map_m, predicted, map, settings);
  best.score = best.value;
  const int n = static_cast<int>(settings.near_m / kLattice_m);
  for (int y = -n; y <= n; ++y) {
    for (int x = -n; x <= n; ++x) {
      const Vec2 place = candidate.place_map_m + kLattice_m * Vec2(x, y);
      const double path_m = field.length_m(map.cell_at(place));
      if (!(path_m <= settings.near_m)) continue;
      const double value = anchor_value(place, predicted, map, settings);
      const double score = value - settings.path_cost * path_m;
      if (score > best.score) best = {candidate.vehicle, place, path_m, value, score};
    }
  }
  return best;
}

}  // namespace

std::optional<PaperAnchor> nearest_to_largest(std::span<const AnchorCandidate> candidates,
                                              std::span<const FrontierSpot> frontiers,
                                              const PathLengths& path_m) {
  const auto f = largest(frontiers);
  if (!f) return std::nullopt;
  std::optional<PaperAnchor> best;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const double d =
        path_m ? path_m(i, *f) : (candidates[i].place_map_m - frontiers[*f].centre_map_m).norm();
    if (std::isnan(d)) continue;
    const bool nearer =
        !best || std::tuple(d, candidates[i].vehicle) < std::tuple(best->distance_m, best->vehicle);
    if (nearer) best = PaperAnchor{candidates[i].vehicle, *f, d};
  }
  return best;
}

std::vector<PredictedLandmark> predict_places(std::span<const Vec2> path_map_m,
                                              const DegenerateAxisAt& degenerate_axis,
                                              double spacing_m) {
  std::vector<PredictedLandmark> out;
  const auto add = [&](const Vec2& p) {
    out.push_back({p, degenerate_axis ? degenerate_axis(p) : std::nullopt});
  };
  double since_m = 0.0;
  for (std::size_t i = 0; i + 1 < path_map_m.size(); ++i) {
    const Vec2 piece = path_map_m[i + 1] - path_map_m[i];
    const double length_m = piece.norm();
    double at_m = spacing_m - since_m;
    for (; at_m < length_m; at_m += spacing_m) add(path_map_m[i] + at_m / length_m * piece);
    since_m = length_m - (at_m - spacing_m);
  }
  if (!path_map_m.empty() && (out.empty() || since_m > kSame_m)) add(path_map_m.back());
  return out;
}

double link_chance(double distance_m, const AnchorSettings& settings) {
  return 1.0 / (1.0 + std::exp((distance_m - settings.range_limit_m) / settings.range_soft_m));
}

double anchor_value(const Vec2& place_map_m, std::span<const PredictedLandmark> predicted,
                    const map::CellMap& map, const AnchorSettings& settings) {
  double sum = 0.0;
  for (const PredictedLandmark& q : predicted) {
    if (!q.degenerate_axis) continue;
    const Vec2 to = q.place_map_m - place_map_m;
    const double distance_m = to.norm();
    if (!(distance_m > kSame_m)) continue;
    const double c = q.degenerate_axis->dot(to) / distance_m;
    const double use = std::min(1.0, c * c / (settings.c_sat * settings.c_sat));
    if (!(use > 0.0)) continue;
    sum += map::sight_fraction(map, place_map_m, q.place_map_m) *
           link_chance(distance_m, settings) * use;
  }
  return sum;
}

std::vector<RankedAnchor> rank_anchors(std::span<const AnchorOption> options,
                                       std::span<const FrontierSpot> frontiers,
                                       const map::CellMap& map,
                                       const std::vector<std::uint8_t>& passable,
                                       const AnchorSettings& settings) {
  struct Item {
    RankedAnchor anchor;
    AnchorUse use;
    double far_m;
  };

  const auto f = largest(frontiers);
  std::vector<Item> ranked;
  for (const AnchorOption& option : options) {
    const AnchorCandidate& c = option.candidate;
    const map::PathField field(map, passable, c.place_map_m);
    const double far_m = f ? distance_to(c, frontiers[*f], &field, map, settings) : kFar;
    RankedAnchor anchor{c.vehicle, c.place_map_m, 0.0, 0.0, -far_m};
    if (settings.choice == AnchorChoice::kInformed) {
      anchor = best_place(c, field, option.predicted, map, settings);
    }
    ranked.push_back({anchor, option.use, far_m});
  }
  std::sort(ranked.begin(), ranked.end(), [](const Item& a, const Item& b) {
    return std::tuple(b.use, -a.anchor.score, a.far_m, a.anchor.vehicle) <
           std::tuple(a.use, -b.anchor.score, b.far_m, b.anchor.vehicle);
  });
  std::vector<RankedAnchor> out;
  for (const Item& item : ranked) out.push_back(item.anchor);
  return out;
}

}  // namespace rali::fleet
