#include "rali/sim/rounds.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/core.h>

#include "rali/sim/route.hpp"

namespace rali::sim {

using geometry::Vec3;

namespace {

constexpr double kGapMin_m = 1.2;    // vehicles are 0.6 m wide and swing laterally
constexpr double kDriveMin_m = 0.3;  // shorter drives are skipped
constexpr int kRoundsMax = 10000;

/// Distance of p from the line segment a to b.
double distance_to_piece(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double squared = ab.squaredNorm();
  const double u = squared > 0.0 ? std::clamp((p - a).dot(ab) / squared, 0.0, 1.0) : 0.0;
  return (p - a - u * ab).norm();
}

/// The lane of one vehicle beside the common path.
class Lane {
 public:
  Lane(const Route& route, double offset_m) : route_(&route), offset_m_(offset_m) {}

  [[nodiscard]] Vec3 point_at(double s_m) const {
    const double yaw = route_->yaw_at(s_m);
    return route_->point_at(s_m) + offset_m_ * Vec3(-std::sin(yaw), std::cos(yaw), 0.0);
  }

  [[nodiscard]] std::vector<Vec3> piece(double from_m, double to_m) const {
    constexpr double kStep_m = 0.25;
    constexpr double kTolerance_m = 0.003;
    const int n = std::max(1, static_cast<int>(std::ceil((to_m - from_m) / kStep_m)));
    std::vector<Vec3> points;
    for (int i = 0; i <= n; ++i) points.push_back(point_at(from_m + (to_m - from_m) * i / n));
    return simplified(points, kTolerance_m);
  }

  [[nodiscard]] VehicleStart start(double s_m) const {
    return {point_at(s_m), route_->yaw_at(s_m)};
  }

 private:
  const Route* route_;
  double offset_m_;
};

/// Positions of the column, by vehicle, and its motion.
class Column {
 public:
  Column(const World& world, int vehicles, double gap_m, const RoundOptions& options)
      : route_(world.route, world.rounding_m), gap_m_(gap_m), leg_m_(options.leg_m) {
    // Lanes only where pedestrians could walk, and no wider than pedestrians swing.
    const double offset = std::clamp(world.free_width_m - 0.4, 0.0, 0.5);
    for (int i = 0; i < vehicles; ++i) {
      lanes_.emplace_back(route_, i % 2 == 0 ? offset : -offset);
      at_m_.push_back(gap_m * (vehicles - 1 - i));
    }
  }

  [[nodiscard]] VehicleStart start(std::size_t i) const { return lanes_[i].start(at_m_[i]); }

  /// Moves all but the anchor; false if no vehicle had to move.
  bool drive_round(std::size_t anchor, RoundPlan& round) {
    round.anchor = static_cast<int>(anchor);
    round.routes.assign(at_m_.size(), {});
    const double anchor_m = at_m_[anchor];
    bool moved = false;
    for (std::size_t i = 0; i < at_m_.size(); ++i) {
      if (i == anchor) continue;
      const double ahead_m = gap_m_ * (static_cast<double>(anchor) - static_cast<double>(i));
      const double last_m = route_.length_m() - gap_m_ * static_cast<double>(i);
      const double to_m = std::min(anchor_m + ahead_m + (i < anchor ? leg_m_ : 0.0), last_m);
      if (to_m < at_m_[i] + kDriveMin_m) continue;
      round.routes[i] = lanes_[i].piece(at_m_[i], to_m);
      at_m_[i] = to_m;
      moved = true;
    }
    return moved;
  }

 private:
  Route route_;
  double gap_m_, leg_m_;
  std::vector<Lane> lanes_;
  std::vector<double> at_m_;
};

double yaw_of_start(const World& world) { return Route(world.route, world.rounding_m).yaw_at(0.0); }

}  // namespace

std::vector<Vec3> simplified(const std::vector<Vec3>& points, double tolerance_m) {
  if (points.size() < 3) return points;
  std::vector<char> kept(points.size(), 0);
  kept.front() = kept.back() = 1;
  std::vector<std::pair<std::size_t, std::size_t>> open{{0, points.size() - 1}};
  while (!open.empty()) {
    const std::pair<std::size_t, std::size_t> piece = open.back();
    open.pop_back();
    double farthest = tolerance_m;
    std::size_t at = 0;
    for (std::size_t i = piece.first + 1; i < piece.second; ++i) {
      const double d = distance_to_piece(points[i], points[piece.first], points[piece.second]);
      if (d > farthest) {
        farthest = d;
        at = i;
      }
    }
    if (at == 0) continue;
    kept[at] = 1;
    open.emplace_back(piece.first, at);
    open.emplace_back(at, piece.second);
  }
  std::vector<Vec3> corners;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (kept[i] != 0) corners.push_back(points[i]);
  }
  return corners;
}

Result<FleetPlan> plan_rounds(const World& world, int vehicles, const RoundOptions& options) {
  FleetPlan plan;
  if (world.route.size() < 2) {
    return fail(ErrorCode::kUsage, "route", "has less than two points",
                "Give the way of the vehicles.");
  }
  if (vehicles == 1) {
    plan.starts.push_back({world.route.front(), yaw_of_start(world)});
    plan.rounds.push_back({-1, {world.route}});
    return plan;
  }
  const double length_m = Route(world.route, world.rounding_m).length_m();
  // The column takes at most half of the path, so that a distance to drive remains.
  const double gap_m = std::min(options.gap_m, 0.5 * length_m / (vehicles - 1));
  if (gap_m < kGapMin_m) {
    return fail(
        ErrorCode::kUsage, "route",
        fmt::format("is {:.1f} m long, too short for {} vehicles in a column", length_m, vehicles),
        "Lengthen it, or give start and rounds for each vehicle.");
  }
  Column column(world, vehicles, gap_m, options);
  const auto n = static_cast<std::size_t>(vehicles);
  for (std::size_t i = 0; i < n; ++i) plan.starts.push_back(column.start(i));
  std::size_t idle = 0;
  for (std::size_t k = 0; idle < n && plan.rounds.size() < kRoundsMax; ++k) {
    RoundPlan round;
    idle = column.drive_round(n - 1 - k % n, round) ? 0 : idle + 1;
    if (idle == 0) plan.rounds.push_back(std::move(round));
  }
  return plan;
}

}  // namespace rali::sim
