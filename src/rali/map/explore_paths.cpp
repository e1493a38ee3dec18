#include "rali/map/explore_paths.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace rali::map {
namespace {

using geometry::Vec2;
using Cell = CellMap::Cell;

constexpr std::array<Cell, 8> kSteps = {
    {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};
constexpr std::uint8_t kNoStep = 8;
constexpr float kFar = std::numeric_limits<float>::infinity();
constexpr double kEnd_m = 0.5;  ///< the vehicles themselves

}  // namespace

std::vector<std::uint8_t> passable_cells(const CellMap& map, double radius_m) {
  std::vector<std::uint8_t> out(map.cells.size(), 0);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = map.cells[i] == CellState::kFree ? 1 : 0;
  std::vector<Cell> disc;
  const int n = static_cast<int>(std::ceil(radius_m / map.cell_m));
  for (int y = -n; y <= n; ++y) {
    for (int x = -n; x <= n; ++x) {
      if (std::hypot(x, y) * map.cell_m <= radius_m) disc.push_back({x, y});
    }
  }
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (map.cells[i] != CellState::kOccupied) continue;
    const Cell c = map.cell(i);
    for (const Cell& d : disc) {
      const Cell near = {c.x + d.x, c.y + d.y};
      if (map.holds(near)) out[map.index(near)] = 0;
    }
  }
  return out;
}

void close_around(const CellMap& map, const Vec2& place_map_m, double radius_m,
                  std::vector<std::uint8_t>& passable) {
  const Cell at = map.cell_at(place_map_m);
  const int n = static_cast<int>(std::ceil(radius_m / map.cell_m));
  for (int y = at.y - n; y <= at.y + n; ++y) {
    for (int x = at.x - n; x <= at.x + n; ++x) {
      const Cell c{x, y};
      if (!map.holds(c) || (map.centre_m(c) - place_map_m).norm() >= radius_m) continue;
      passable[map.index(c)] = 0;
    }
  }
}

PathField::PathField(const CellMap& map, const std::vector<std::uint8_t>& passable,
                     const Vec2& start_map_m, double escape_m)
    : map_(&map),
      passable_(&passable),
      length_m_(map.cells.size(), kFar),
      from_(map.cells.size(), kNoStep) {
  const Cell at = map.cell_at(start_map_m);
  const int n = static_cast<int>(std::ceil(escape_m / map.cell_m));
  std::optional<std::size_t> start;
  double nearest_m = escape_m;
  for (int y = at.y - n; y <= at.y + n; ++y) {
    for (int x = at.x - n; x <= at.x + n; ++x) {
      if (!map.holds({x, y}) || passable[map.index({x, y})] == 0) continue;
      const double d = (map.centre_m({x, y}) - start_map_m).norm();
      if (!(d <= nearest_m) || (start && d >= nearest_m)) continue;
      nearest_m = d;
      start = map.index({x, y});
    }
  }
  if (start) flood(*start);
}

void PathField::flood(std::size_t start) {
  using Entry = std::pair<float, std::size_t>;  // equal lengths: ordered by cell, so the result is
                                                // unique
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  length_m_[start] = 0.0F;
  open.push({0.0F, start});
  const auto straight = static_cast<float>(map_->cell_m);
  const float diagonal = straight * std::sqrt(2.0F);
  while (!open.empty()) {
    const auto [length, i] = open.top();
    open.pop();
    if (length > length_m_[i]) continue;
    const Cell c = map_->cell(i);
    for (std::uint8_t k = 0; k < kSteps.size(); ++k) {
      const Cell to = {c.x + kSteps[k].x, c.y + kSteps[k].y};
      if (!map_->holds(to)) continue;
      const std::size_t j = map_->index(to);
      const float there = length + (k % 2 == 0 ? straight : diagonal);
      if ((*passable_)[j] == 0 || !(there < length_m_[j])) continue;
      length_m_[j] = there;
      from_[j] = k;
      open.push({there, j});
    }
  }
}

double PathField::length_m(const Cell& to) const {
  if (!map_->holds(to)) return std::numeric_limits<double>::infinity();
  return static_cast<double>(length_m_[map_->index(to)]);
}

bool PathField::sees(const Cell& a, const Cell& b) const {
  const int n = 2 * std::max(std::abs(b.x - a.x), std::abs(b.y - a.y));
  for (int k = 1; k < n; ++k) {
    const double s = static_cast<double>(k) / n;
    const Cell c = {static_cast<int>(std::lround(a.x + s * (b.x - a.x))),
                    static_cast<int>(std::lround(a.y + s * (b.y - a.y)))};
    if ((*passable_)[map_->index(c)] == 0) return false;
  }
  return true;
}

std::vector<Vec2> PathField::path_to(const Cell& to) const {
  if (!std::isfinite(length_m(to))) return {};
  std::vector<Cell> path = {to};
  for (std::uint8_t k = from_[map_->index(to)]; k != kNoStep; k = from_[map_->index(path.back())]) {
    path.push_back({path.back().x - kSteps[k].x, path.back().y - kSteps[k].y});
  }
  std::reverse(path.begin(), path.end());
  std::vector<Vec2> corners = {map_->centre_m(path.front())};
  std::size_t last = 0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    // The longest straight line from the last corner that stays passable.
    if (i + 1 < path.size() && sees(path[last], path[i + 1])) continue;
    corners.push_back(map_->centre_m(path[i]));
    last = i;
  }
  return corners;
}

double sight_fraction(const CellMap& map, const Vec2& from_map_m, const Vec2& to_map_m) {
  const double distance_m = (to_map_m - from_map_m).norm();
  if (!std::isfinite(distance_m)) return 0.0;
  const double step_m = 0.5 * map.cell_m;
  const int n = static_cast<int>(std::min(distance_m / step_m, 1e6));
  double fraction = 1.0;
  for (int k = 1; k < n; ++k) {
    const double s = static_cast<double>(k) / n;
    const Vec2 p = from_map_m + s * (to_map_m - from_map_m);
    const CellState state = map.at(map.cell_at(p));
    const bool is_end = s * distance_m < kEnd_m || (1.0 - s) * distance_m < kEnd_m;
    if (state == CellState::kOccupied && !is_end) return 0.0;
    if (state == CellState::kUnknown) fraction = 0.5;
  }
  return fraction;
}

}  // namespace rali::map
