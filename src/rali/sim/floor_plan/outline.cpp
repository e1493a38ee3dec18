#include "rali/sim/floor_plan/outline.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <tuple>
#include <utility>

#include <fmt/core.h>

namespace rali::sim {

using geometry::Vec2;

namespace {

constexpr double kSnap_m = 1e-6;   // closer corners are merged
constexpr double kProbe_m = 2e-5;  // from an edge to the points that sample its two sides
constexpr std::size_t kWallsMax = 5000;
constexpr std::size_t kPiecesMax = 200'000;

struct Edge {
  Vec2 a, b;
  std::vector<double> cuts;  ///< 0..1
};

double cross2(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

Vec2 snapped(const Vec2& p) {
  // +0.0 turns a negative zero into zero: one point, one value.
  return {std::round(p.x() / kSnap_m) * kSnap_m + 0.0, std::round(p.y() / kSnap_m) * kSnap_m + 0.0};
}

/// Cuts `edge` at p if p lies on it.
void cut_at(Edge& edge, const Vec2& p) {
  const Vec2 along = edge.b - edge.a;
  const double u = (p - edge.a).dot(along) / along.squaredNorm();
  if (u <= 0.0 || u >= 1.0) return;
  if ((edge.a + u * along - p).norm() < kSnap_m) edge.cuts.push_back(u);
}

void cut_each_other(Edge& e, Edge& f) {
  const Vec2 low_e = e.a.cwiseMin(e.b).array() - kSnap_m;
  const Vec2 high_e = e.a.cwiseMax(e.b).array() + kSnap_m;
  if ((f.a.cwiseMax(f.b).array() < low_e.array()).any()) return;
  if ((f.a.cwiseMin(f.b).array() > high_e.array()).any()) return;
  for (const Vec2& p : {f.a, f.b}) cut_at(e, p);
  for (const Vec2& p : {e.a, e.b}) cut_at(f, p);
  const Vec2 de = e.b - e.a;
  const Vec2 df = f.b - f.a;
  const double cross = cross2(de, df);
  if (std::abs(cross) < 1e-12 * de.norm() * df.norm()) return;
  const double u = cross2(f.a - e.a, df) / cross;
  const double v = cross2(f.a - e.a, de) / cross;
  if (u <= 0.0 || u >= 1.0 || v <= 0.0 || v >= 1.0) return;
  e.cuts.push_back(u);
  f.cuts.push_back(v);
}

std::vector<Edge> cut_edges(const std::vector<FreeArea>& areas) {
  std::vector<Edge> edges;
  for (const FreeArea& area : areas) {
    for (std::size_t i = 0; i < area.corners.size(); ++i) {
      const Vec2& b = area.corners[(i + 1) % area.corners.size()];
      edges.push_back({snapped(area.corners[i]), snapped(b), {0.0, 1.0}});
    }
  }
  for (std::size_t i = 0; i < edges.size(); ++i) {
    for (std::size_t j = i + 1; j < edges.size(); ++j) cut_each_other(edges[i], edges[j]);
  }
  return edges;
}

bool point_less(const Vec2& a, const Vec2& b) {
  return std::pair(a.x(), a.y()) < std::pair(b.x(), b.y());
}

/// Adds a wall over the segment a to b if its sides differ.
void add_wall(const std::vector<FreeArea>& areas, const Vec2& a, const Vec2& b,
              std::vector<WallPiece>& walls) {
  const Vec2 along = (b - a).normalized();
  const Vec2 lateral = kProbe_m * Vec2(-along.y(), along.x());
  const Vec2 middle = 0.5 * (a + b);
  const FreeArea* left = area_at(areas, middle + lateral);
  const FreeArea* right = area_at(areas, middle - lateral);
  const double height_left = left != nullptr ? left->height_m : 0.0;
  const double height_right = right != nullptr ? right->height_m : 0.0;
  if (height_left == height_right) return;
  const FreeArea& higher = height_left > height_right ? *left : *right;
  walls.push_back(
      {a, b, std::min(height_left, height_right), higher.height_m, higher.wall_reflectivity});
}

bool continues(const WallPiece& one, const WallPiece& next) {
  if (one.bottom_m != next.bottom_m || one.top_m != next.top_m) return false;
  if (one.reflectivity != next.reflectivity || (one.b - next.a).norm() > kSnap_m) return false;
  const Vec2 u = (one.b - one.a).normalized();
  return std::abs(cross2(u, (next.b - next.a).normalized())) < 1e-9;
}

/// Joins consecutive segments on one line.
std::vector<WallPiece> joined(const std::vector<WallPiece>& pieces) {
  std::vector<WallPiece> walls;
  std::vector<char> used(pieces.size(), 0);
  for (std::size_t i = 0; i < pieces.size(); ++i) {  // sorted by a: successors come later
    if (used[i] != 0) continue;
    WallPiece wall = pieces[i];
    for (std::size_t j = i + 1; j < pieces.size(); ++j) {
      if (pieces[j].a.x() > wall.b.x() + kSnap_m) break;
      if (used[j] != 0 || !continues(wall, pieces[j])) continue;
      wall.b = pieces[j].b;
      used[j] = 1;
    }
    walls.push_back(wall);
  }
  return walls;
}

double y_at(const WallPiece& wall, double x) {
  return wall.a.y() + (wall.b.y() - wall.a.y()) * (x - wall.a.x()) / (wall.b.x() - wall.a.x());
}

std::vector<SlabPiece> slabs_of(const std::vector<FreeArea>& areas,
                                const std::vector<WallPiece>& walls) {
  std::set<double> ends;
  for (const WallPiece& wall : walls) {
    ends.insert(wall.a.x());
    ends.insert(wall.b.x());
  }
  std::vector<SlabPiece> slabs;
  if (ends.empty()) return slabs;
  for (auto it = ends.begin(); std::next(it) != ends.end(); ++it) {
    const double x0 = *it;
    const double x1 = *std::next(it);
    const double middle = 0.5 * (x0 + x1);
    std::vector<std::pair<double, const WallPiece*>> crossed;
    for (const WallPiece& wall : walls) {  // a.x <= b.x
      if (wall.a.x() <= x0 && wall.b.x() >= x1 && wall.b.x() > wall.a.x()) {
        crossed.emplace_back(y_at(wall, middle), &wall);
      }
    }
    std::sort(crossed.begin(), crossed.end());
    for (std::size_t i = 0; i + 1 < crossed.size(); ++i) {
      const WallPiece& low = *crossed[i].second;
      const WallPiece& high = *crossed[i + 1].second;
      const Vec2 centre(middle, 0.5 * (crossed[i].first + crossed[i + 1].first));
      const FreeArea* area = area_at(areas, centre);
      if (area == nullptr) continue;
      slabs.push_back(
          {x0, x1, y_at(low, x0), y_at(high, x0), y_at(low, x1), y_at(high, x1), area->height_m});
    }
  }
  return slabs;
}

}  // namespace

const FreeArea* area_at(const std::vector<FreeArea>& areas, const Vec2& p) {
  const FreeArea* best = nullptr;
  for (const FreeArea& area : areas) {
    if (best != nullptr && best->height_m > area.height_m) continue;
    if (is_inside(area.corners, p)) best = &area;
  }
  return best;
}

Result<Outline> outline_of(const std::vector<FreeArea>& areas) {
  std::vector<Edge> edges = cut_edges(areas);
  std::size_t cuts = 0;
  for (const Edge& edge : edges) cuts += edge.cuts.size();
  const auto too_many = [] {
    return fail(ErrorCode::kUsage, "floor_plan",
                fmt::format("its areas cut each other into more than {} walls", kWallsMax),
                "Use fewer corners.");
  };
  if (cuts > kPiecesMax) return too_many();
  std::set<std::tuple<double, double, double, double>> seen;
  std::vector<WallPiece> pieces;
  for (Edge& edge : edges) {
    std::sort(edge.cuts.begin(), edge.cuts.end());
    for (std::size_t i = 0; i + 1 < edge.cuts.size(); ++i) {
      Vec2 a = snapped(edge.a + edge.cuts[i] * (edge.b - edge.a));
      Vec2 b = snapped(edge.a + edge.cuts[i + 1] * (edge.b - edge.a));
      if ((b - a).norm() < 2.0 * kSnap_m) continue;
      if (point_less(b, a)) std::swap(a, b);
      if (!seen.insert({a.x(), a.y(), b.x(), b.y()}).second) continue;
      add_wall(areas, a, b, pieces);
      if (pieces.size() > kWallsMax) return too_many();
    }
  }
  std::sort(pieces.begin(), pieces.end(), [](const WallPiece& p, const WallPiece& q) {
    return std::tuple(p.a.x(), p.a.y(), p.b.x(), p.b.y()) <
           std::tuple(q.a.x(), q.a.y(), q.b.x(), q.b.y());
  });
  Outline outline;
  outline.walls = joined(pieces);
  outline.slabs = slabs_of(areas, outline.walls);
  return outline;
}

}  // namespace rali::sim
