#include "rali/sim/navigation.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <queue>
#include <tuple>

#include <fmt/core.h>

#include "rali/sim/internal/spans.hpp"

namespace rali::sim {

using geometry::Vec3;
using internal::Span;

namespace {

// Straight steps first, so that a diagonal step can check its two straight neighbours.
constexpr std::array<std::array<int, 2>, 8> kSteps{
    {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};
constexpr double kReach_m = 0.5;  ///< in height, between a point and the ground

double step_length(std::size_t k) { return k < 4 ? 1.0 : std::sqrt(2.0); }

/// Open node of a search; smallest cost first, then smallest index, so that the order is the same
/// on every machine.
struct Open {
  float cost;
  std::int32_t node;

  bool operator<(const Open& other) const {
    return std::tie(other.cost, other.node) < std::tie(cost, node);
  }
};

}  // namespace

Result<NavigationGrid> NavigationGrid::build(const TriangleMesh& mesh,
                                             const NavigationOptions& options) {
  if (mesh.triangles.empty()) return fail(ErrorCode::kUsage, "mesh", "has no triangles");
  constexpr double kCellsMax = 3e7;
  constexpr double kCellMax_m = 0.25;
  NavigationGrid grid(options);
  while (internal::cells_touched(mesh, grid.options_.cell_m) > kCellsMax) {
    grid.options_.cell_m *= 1.25;
    if (grid.options_.cell_m > kCellMax_m) {
      return fail(ErrorCode::kUsage, "mesh", "is too large to plan paths in it",
                  "Give the routes, or cut the mesh to the part that is driven.");
    }
  }
  grid.low_ = mesh.lower_corner().head<2>();
  grid.make_nodes(mesh);
  grid.link_nodes();
  grid.measure_clearance();
  grid.find_parts();
  return grid;
}

void NavigationGrid::make_nodes(const TriangleMesh& mesh) {
  const std::vector<Span> spans = internal::rasterised(mesh, low_, options_.cell_m);
  for (std::size_t i = 0; i < spans.size(); ++i) {
    const bool last = i + 1 == spans.size() || !internal::same_cell(spans[i], spans[i + 1]);
    if (!last && static_cast<double>(spans[i + 1].low_m - spans[i].high_m) < options_.height_m) {
      continue;
    }
    Node node;
    node.x = spans[i].x;
    node.y = spans[i].y;
    node.z_m = spans[i].high_m;
    node.next.fill(-1);
    nodes_.push_back(node);
  }
}

void NavigationGrid::link_nodes() {
  for (Node& node : nodes_) {
    for (std::size_t k = 0; k < kSteps.size(); ++k) {
      const double reach = options_.step_m * step_length(k);
      node.next[k] = node_at(node.x + kSteps[k][0], node.y + kSteps[k][1],
                             static_cast<double>(node.z_m), reach);
    }
  }
  for (Node& node : nodes_) {  // no cutting of corners
    for (std::size_t k = 4; k < 8; ++k) {
      if (node.next[k - 4] < 0 || node.next[(k - 3) % 4] < 0) node.next[k] = -1;
    }
  }
}

void NavigationGrid::measure_clearance() {
  constexpr float kFar_m = 1e9F;
  std::priority_queue<Open> open;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const auto straight_end = nodes_[i].next.begin() + 4;
    const bool at_edge = std::find(nodes_[i].next.begin(), straight_end, -1) != straight_end;
    nodes_[i].clearance_m = at_edge ? static_cast<float>(0.5 * options_.cell_m) : kFar_m;
    if (at_edge) open.push({nodes_[i].clearance_m, static_cast<std::int32_t>(i)});
  }
  while (!open.empty()) {
    const Open top = open.top();
    open.pop();
    const Node& node = nodes_[static_cast<std::size_t>(top.node)];
    if (top.cost > node.clearance_m) continue;
    for (std::size_t k = 0; k < kSteps.size(); ++k) {
      if (node.next[k] < 0) continue;
      const auto far = top.cost + static_cast<float>(step_length(k) * options_.cell_m);
      Node& other = nodes_[static_cast<std::size_t>(node.next[k])];
      if (far >= other.clearance_m) continue;
      other.clearance_m = far;
      open.push({far, node.next[k]});
    }
  }
}

void NavigationGrid::find_parts() {
  std::int32_t parts = 0;
  std::vector<std::int32_t> open;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (nodes_[i].part >= 0 || !passable(static_cast<std::int32_t>(i))) continue;
    nodes_[i].part = parts;
    open.push_back(static_cast<std::int32_t>(i));
    while (!open.empty()) {
      const Node& node = nodes_[static_cast<std::size_t>(open.back())];
      open.pop_back();
      for (const std::int32_t next : node.next) {
        if (!passable(next) || nodes_[static_cast<std::size_t>(next)].part >= 0) continue;
        nodes_[static_cast<std::size_t>(next)].part = parts;
        open.push_back(next);
      }
    }
    ++parts;
  }
}

std::int32_t NavigationGrid::node_at(std::int64_t x, std::int64_t y, double z_m,
                                     double reach_m) const {
  const auto before = [](const Node& node, const std::pair<std::int64_t, std::int64_t>& cell) {
    return std::tie(node.y, node.x) < std::tie(cell.second, cell.first);
  };
  auto it = std::lower_bound(nodes_.begin(), nodes_.end(), std::pair(x, y), before);
  double nearest = reach_m;
  std::int32_t found = -1;
  for (; it != nodes_.end() && it->x == x && it->y == y; ++it) {
    const double away = std::abs(static_cast<double>(it->z_m) - z_m);
    if (away > nearest) continue;
    nearest = away;
    found = static_cast<std::int32_t>(it - nodes_.begin());
  }
  return found;
}

std::int32_t NavigationGrid::node_of(const Vec3& p) const {
  if (!p.allFinite() || p.cwiseAbs().maxCoeff() > 1e7) return -1;
  const auto x = static_cast<std::int64_t>(std::floor((p.x() - low_.x()) / options_.cell_m));
  const auto y = static_cast<std::int64_t>(std::floor((p.y() - low_.y()) / options_.cell_m));
  return node_at(x, y, p.z(), kReach_m);
}

Vec3 NavigationGrid::centre(std::int32_t node) const {
  const Node& n = nodes_[static_cast<std::size_t>(node)];
  return {low_.x() + (n.x + 0.5) * options_.cell_m, low_.y() + (n.y + 0.5) * options_.cell_m,
          static_cast<double>(n.z_m)};
}

bool NavigationGrid::passable(std::int32_t node) const {
  return node >= 0 && static_cast<double>(nodes_[static_cast<std::size_t>(node)].clearance_m) >=
                          options_.radius_m;
}

bool NavigationGrid::free_at(const Vec3& p) const { return passable(node_of(p)); }

std::int32_t NavigationGrid::part_at(const Vec3& p) const {
  const std::int32_t node = node_of(p);
  return node < 0 ? -1 : nodes_[static_cast<std::size_t>(node)].part;
}

std::optional<double> NavigationGrid::ground_at(double x_m, double y_m, double z_m) const {
  constexpr double kAny_m = 1e6;
  const auto x = static_cast<std::int64_t>(std::floor((x_m - low_.x()) / options_.cell_m));
  const auto y = static_cast<std::int64_t>(std::floor((y_m - low_.y()) / options_.cell_m));
  const std::int32_t node = node_at(x, y, z_m, kAny_m);
  if (node < 0) return std::nullopt;
  return static_cast<double>(nodes_[static_cast<std::size_t>(node)].z_m);
}

double NavigationGrid::clearance_m(const Vec3& p) const {
  const std::int32_t node = node_of(p);
  return node < 0 ? 0.0 : static_cast<double>(nodes_[static_cast<std::size_t>(node)].clearance_m);
}

std::vector<Vec3> NavigationGrid::free_cells() const {
  std::vector<Vec3> cells;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const auto node = static_cast<std::int32_t>(i);
    if (passable(node)) cells.push_back(centre(node));
  }
  return cells;
}

void NavigationGrid::search(std::int32_t from, std::int32_t to, std::vector<std::int32_t>& before,
                            std::vector<float>& cost) const {
  before.assign(nodes_.size(), -1);
  cost.assign(nodes_.size(), std::numeric_limits<float>::infinity());
  const Vec3 goal = to >= 0 ? centre(to) : Vec3::Zero();
  const auto ahead = [&](std::int32_t node) {
    return to < 0 ? 0.0F : static_cast<float>((centre(node) - goal).head<2>().norm());
  };
  std::priority_queue<Open> open;
  cost[static_cast<std::size_t>(from)] = 0.0F;
  open.push({ahead(from), from});
  while (!open.empty()) {
    const Open top = open.top();
    open.pop();
    if (top.node == to) return;
    const float here = cost[static_cast<std::size_t>(top.node)];
    if (top.cost > here + ahead(top.node)) continue;
    const Node& node = nodes_[static_cast<std::size_t>(top.node)];
    for (std::size_t k = 0; k < kSteps.size(); ++k) {
      const std::int32_t next = node.next[k];
      if (!passable(next)) continue;
      const double room = static_cast<double>(nodes_[static_cast<std::size_t>(next)].clearance_m);
      // The cost is doubled beside a wall and falls to one at the preferred distance.
      const double price = 1.0 + std::max(0.0, 1.0 - room / options_.prefer_m);
      const auto far = here + static_cast<float>(step_length(k) * options_.cell_m * price);
      if (far >= cost[static_cast<std::size_t>(next)]) continue;
      cost[static_cast<std::size_t>(next)] = far;
      before[static_cast<std::size_t>(next)] = top.node;
      open.push({far + ahead(next), next});
    }
  }
}

double NavigationGrid::line_clearance(std::int32_t from, std::int32_t to) const {
  const Vec3 a = centre(from);
  const Vec3 step = centre(to) - a;
  const int n =
      std::max(1, static_cast<int>(std::ceil(step.head<2>().norm() / (0.5 * options_.cell_m))));
  double minimum = std::numeric_limits<double>::infinity();
  std::int32_t here = from;
  for (int i = 1; i <= n; ++i) {
    const Vec3 p = a + step * (static_cast<double>(i) / n);
    const Node& node = nodes_[static_cast<std::size_t>(here)];
    const auto x = static_cast<std::int64_t>(std::floor((p.x() - low_.x()) / options_.cell_m));
    const auto y = static_cast<std::int64_t>(std::floor((p.y() - low_.y()) / options_.cell_m));
    if (x != node.x || y != node.y) {
      // Height from the cell before, not from the line: ground may be curved.
      here = node_at(x, y, static_cast<double>(node.z_m), 2.0 * options_.step_m);
      if (!passable(here)) return -1.0;
    }
    const double room = static_cast<double>(nodes_[static_cast<std::size_t>(here)].clearance_m);
    minimum = std::min(minimum, room);
  }
  return here == to ? minimum : -1.0;
}

std::vector<std::int32_t> NavigationGrid::shortened(const std::vector<std::int32_t>& path) const {
  constexpr std::size_t kFarthest = 400;  // nodes replaced by one straight segment
  std::vector<std::int32_t> corners{path.front()};
  std::size_t at = 0;
  while (at + 1 < path.size()) {
    double minimum = options_.prefer_m;  // shortcuts keep at least this distance from walls
    std::size_t best = at + 1;
    const std::size_t end = std::min(path.size(), at + kFarthest);
    for (std::size_t i = at + 1; i < end; ++i) {
      const Node& node = nodes_[static_cast<std::size_t>(path[i])];
      minimum = std::min(minimum, static_cast<double>(node.clearance_m));
      if (line_clearance(path[at], path[i]) >= minimum) best = i;
    }
    at = best;
    corners.push_back(path[at]);
  }
  return corners;
}

Result<std::vector<Vec3>> NavigationGrid::plan(const Vec3& from, const Vec3& to) const {
  const std::int32_t first = node_of(from);
  const std::int32_t last = node_of(to);
  for (const bool is_from : {true, false}) {
    if (passable(is_from ? first : last)) continue;
    const Vec3& p = is_from ? from : to;
    return fail(
        ErrorCode::kUsage, is_from ? "from" : "to",
        fmt::format("no vehicle can stand at [{:.2f}, {:.2f}, {:.2f}]", p.x(), p.y(), p.z()));
  }
  std::vector<std::int32_t> before;
  std::vector<float> cost;
  search(first, last, before, cost);
  if (first != last && before[static_cast<std::size_t>(last)] < 0) {
    return fail(ErrorCode::kNoAnswer, "plan",
                fmt::format("there is no path from [{:.2f}, {:.2f}] to [{:.2f}, {:.2f}] for a "
                            "vehicle of radius {} m",
                            from.x(), from.y(), to.x(), to.y(), options_.radius_m));
  }
  std::vector<std::int32_t> path;
  for (std::int32_t node = last; node >= 0; node = before[static_cast<std::size_t>(node)]) {
    path.push_back(node);
  }
  std::reverse(path.begin(), path.end());
  std::vector<Vec3> points;
  for (const std::int32_t node : shortened(path)) points.push_back(centre(node));
  if (points.size() == 1) points.push_back(points.front());
  points.front() = {from.x(), from.y(), points.front().z()};
  points.back() = {to.x(), to.y(), points.back().z()};
  return points;
}

Result<Vec3> NavigationGrid::farthest_from(const Vec3& from) const {
  const std::int32_t first = node_of(from);
  if (!passable(first)) {
    return fail(ErrorCode::kUsage, "from",
                fmt::format("no vehicle can stand at [{:.2f}, {:.2f}, {:.2f}]", from.x(), from.y(),
                            from.z()));
  }
  std::vector<std::int32_t> before;
  std::vector<float> cost;
  search(first, -1, before, cost);
  std::int32_t best = first;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (std::isfinite(cost[i]) && cost[i] > cost[static_cast<std::size_t>(best)]) {
      best = static_cast<std::int32_t>(i);
    }
  }
  return centre(best);
}

}  // namespace rali::sim
