#include "rali/map/frontiers.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace rali::map {
namespace {

using geometry::Vec2;
using Cell = CellMap::Cell;

constexpr std::size_t kMedoidMax = 1000;  ///< with more cells only every second, third, ... is
                                          ///< tried
constexpr std::size_t kBookMax = 10'000;
constexpr double kSameSize = 0.2;  ///< fraction by which a frontier may change and remain the same
constexpr double kSame_m = 0.5;

bool touches(const CellMap& map, const Cell& c, CellState state) {
  for (int y = c.y - 1; y <= c.y + 1; ++y) {
    for (int x = c.x - 1; x <= c.x + 1; ++x) {
      if (map.at({x, y}) == state) return true;
    }
  }
  return false;
}

/// An unknown cell at an obstacle is its edge, which rays miss at times, and not open space.
bool has_unknown_neighbour(const CellMap& map, const Cell& c) {
  for (int y = c.y - 1; y <= c.y + 1; ++y) {
    for (int x = c.x - 1; x <= c.x + 1; ++x) {
      const bool unknown = map.at({x, y}) == CellState::kUnknown;
      if (unknown && !touches(map, {x, y}, CellState::kOccupied)) return true;
    }
  }
  return false;
}

std::vector<Cell> grow(const CellMap& map, std::vector<std::uint8_t>& open, std::size_t seed) {
  std::vector<std::size_t> found = {seed};
  open[seed] = 0;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const Cell c = map.cell(found[k]);
    for (int y = c.y - 1; y <= c.y + 1; ++y) {
      for (int x = c.x - 1; x <= c.x + 1; ++x) {
        if (!map.holds({x, y}) || open[map.index({x, y})] == 0) continue;
        open[map.index({x, y})] = 0;
        found.push_back(map.index({x, y}));
      }
    }
  }
  std::sort(found.begin(), found.end());
  std::vector<Cell> cells;
  for (const std::size_t i : found) cells.push_back(map.cell(i));
  return cells;
}

Vec2 mean_of(const CellMap& map, const std::vector<Cell>& cells) {
  Vec2 sum = Vec2::Zero();
  for (const Cell& c : cells) sum += map.centre_m(c);
  return sum / static_cast<double>(cells.size());
}

/// The cell with the smallest sum of distances to the others.
Vec2 medoid_of(const CellMap& map, const std::vector<Cell>& cells) {
  const std::size_t stride = 1 + cells.size() / kMedoidMax;
  double minimum = std::numeric_limits<double>::infinity();
  Vec2 best = Vec2::Zero();
  for (const Cell& c : cells) {
    double sum = 0.0;
    for (std::size_t k = 0; k < cells.size(); k += stride) {
      sum += std::hypot(c.x - cells[k].x, c.y - cells[k].y);
    }
    if (!(sum < minimum)) continue;
    minimum = sum;
    best = map.centre_m(c);
  }
  return best;
}

/// Unknown cells that are joined to the frontier through unknown ones within `reach` steps; all
/// cells outside the map are unknown.
double unknown_area(const CellMap& map, const std::vector<Cell>& cells, int reach) {
  const int width = map.width + 2 * reach;
  const auto slot = [&](const Cell& c) {
    return static_cast<std::size_t>(c.y + reach) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(c.x + reach);
  };
  std::vector<std::uint8_t> seen(
      static_cast<std::size_t>(width) * static_cast<std::size_t>(map.height + 2 * reach), 0);
  std::vector<Cell> ring = cells;
  std::size_t count = 0;
  for (int step = 0; step < reach && !ring.empty(); ++step) {
    std::vector<Cell> next;
    for (const Cell& c : ring) {
      for (int k = 0; k < 4; ++k) {
        const Cell to = {c.x + (k == 0) - (k == 1), c.y + (k == 2) - (k == 3)};
        const bool inside = to.x >= -reach && to.y >= -reach && to.x < map.width + reach &&
                            to.y < map.height + reach;
        if (!inside || map.at(to) != CellState::kUnknown || seen[slot(to)] != 0) continue;
        seen[slot(to)] = 1;
        ++count;
        next.push_back(to);
      }
    }
    ring = std::move(next);
  }
  return static_cast<double>(count) * map.cell_m * map.cell_m;
}

void measure(const CellMap& map, std::span<const PathField> from, const FrontierSettings& settings,
             FrontierArea& f) {
  f.length_m = static_cast<double>(f.cells.size()) * map.cell_m;
  f.centre_map_m =
      settings.centre == FrontierCentre::kMean ? mean_of(map, f.cells) : medoid_of(map, f.cells);
  f.path_m = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < from.size(); ++k) {
    for (const Cell& c : f.cells) {
      if (!(from[k].length_m(c) < f.path_m)) continue;
      f.path_m = from[k].length_m(c);
      f.nearest = k;
    }
  }
  if (f.length_m < settings.length_min_m - 1e-9) {
    f.state = FrontierState::kTooSmall;
  } else if (!std::isfinite(f.path_m)) {
    f.state = FrontierState::kUnreachable;
  }
  if (f.state == FrontierState::kOpen) {
    const double reach = std::max(1.0, std::round(settings.unknown_reach_m / map.cell_m));
    f.unknown_area_m2 = unknown_area(map, f.cells, static_cast<int>(reach));
  }
  f.size = settings.size == FrontierSize::kCells    ? static_cast<double>(f.cells.size())
           : settings.size == FrontierSize::kLength ? f.length_m
                                                    : f.unknown_area_m2;
}

}  // namespace

std::vector<FrontierArea> find_frontiers(const CellMap& map,
                                         const std::vector<std::uint8_t>& passable,
                                         std::span<const PathField> from,
                                         const FrontierSettings& settings) {
  std::vector<std::uint8_t> open(map.cells.size(), 0);
  for (std::size_t i = 0; i < open.size(); ++i) {
    open[i] = passable[i] != 0 && has_unknown_neighbour(map, map.cell(i)) ? 1 : 0;
  }
  std::vector<FrontierArea> out;
  for (std::size_t i = 0; i < open.size(); ++i) {
    if (open[i] == 0) continue;
    FrontierArea f;
    f.cells = grow(map, open, i);
    measure(map, from, settings, f);
    out.push_back(std::move(f));
  }
  return out;
}

FrontierBook::Entry* FrontierBook::entry_of(const FrontierArea& frontier) {
  Entry* best = nullptr;
  double nearest_m = settings_.merge_m;
  for (Entry& e : entries_) {
    const double d = (e.frontier.centre_map_m - frontier.centre_map_m).norm();
    if (e.present || d > nearest_m) continue;
    nearest_m = d;
    best = &e;
  }
  return best;
}

void FrontierBook::name(std::vector<FrontierArea>& frontiers) {
  for (Entry& e : entries_) e.present = false;
  for (FrontierArea& f : frontiers) {
    Entry* e = entry_of(f);
    if (e == nullptr) {
      entries_.push_back({{++last_id_, f.centre_map_m, f.size, 0}, false});
      e = &entries_.back();
    }
    NamedFrontier& known = e->frontier;
    const bool same = (known.centre_map_m - f.centre_map_m).norm() <= kSame_m &&
                      std::abs(known.size - f.size) <= kSameSize * known.size;
    if (!same) known = {known.id, f.centre_map_m, f.size, 0};
    e->present = true;
    f.id = known.id;
    const bool given_up = known.visits >= settings_.visits_max;
    if (given_up && f.state == FrontierState::kOpen) f.state = FrontierState::kExplored;
  }
  std::erase_if(entries_, [](const Entry& e) { return !e.present; });
  if (entries_.size() > kBookMax) entries_.resize(kBookMax);
}

void FrontierBook::visited(const Vec2& place_map_m) {
  for (Entry& e : entries_) {
    if ((e.frontier.centre_map_m - place_map_m).norm() <= settings_.visit_m) ++e.frontier.visits;
  }
}

void FrontierBook::found_no_path(VehicleId vehicle, const Vec2& place_map_m) {
  if (has_no_path(vehicle, place_map_m)) return;
  if (no_path_.size() >= kBookMax) no_path_.erase(no_path_.begin());
  no_path_.push_back({vehicle, place_map_m});
}

bool FrontierBook::has_no_path(VehicleId vehicle, const Vec2& place_map_m) const {
  return std::any_of(no_path_.begin(), no_path_.end(), [&](const NoPath& n) {
    return n.vehicle == vehicle && (n.place_map_m - place_map_m).norm() <= kSame_m;
  });
}

void FrontierBook::give_up_unreached(std::vector<FrontierArea>& frontiers,
                                     std::span<const VehicleId> vehicles) const {
  if (vehicles.empty()) return;
  for (FrontierArea& f : frontiers) {
    if (f.state != FrontierState::kOpen) continue;
    f.tried = std::all_of(vehicles.begin(), vehicles.end(),
                          [&](VehicleId v) { return has_no_path(v, f.centre_map_m); });
    if (f.tried) f.state = FrontierState::kUnreachable;
  }
}

void FrontierBook::take(const FrontierMemory& newer) {
  entries_.clear();
  no_path_ = newer.no_path;
  for (const NamedFrontier& f : newer.named) entries_.push_back({f, true});
  last_id_ = std::max(last_id_, newer.last_id);
}

FrontierMemory FrontierBook::memory() const {
  FrontierMemory memory;
  for (const Entry& e : entries_) memory.named.push_back(e.frontier);
  memory.last_id = last_id_;
  memory.no_path = no_path_;
  return memory;
}

}  // namespace rali::map
