#include "mine.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rali/base/rng.hpp"

namespace rali::view_demo {
namespace {

struct Gallery {
  double x0, y0, x1, y1, width_m, height_m;
};

// The main gallery, two side galleries, a chamber at the end.
constexpr std::array<Gallery, 4> kGalleries = {{{-4, 0, 78, 0, 4.2, 3.2},
                                                {30, 0, 30, 44, 3.6, 2.9},
                                                {58, 0, 58, -38, 3.6, 2.9},
                                                {76, 0, 96, 0, 15.0, 4.6}}};

bool inside(const Gallery& g, double x, double y, double margin_m) {
  const double length = std::hypot(g.x1 - g.x0, g.y1 - g.y0);
  const double ux = (g.x1 - g.x0) / length, uy = (g.y1 - g.y0) / length;
  const double along = (x - g.x0) * ux + (y - g.y0) * uy;
  const double lateral = -(x - g.x0) * uy + (y - g.y0) * ux;
  return along > margin_m && along < length - margin_m &&
         std::abs(lateral) < 0.5 * g.width_m - margin_m;
}

void add_gallery(const Gallery& g, Rng& rng, std::vector<Point>& out) {
  constexpr double kStep_m = 0.16;
  const double length = std::hypot(g.x1 - g.x0, g.y1 - g.y0);
  const double ux = (g.x1 - g.x0) / length, uy = (g.y1 - g.y0) / length;
  const double half = 0.5 * g.width_m;
  const auto add = [&](double along, double lateral, double z) {
    const double rough = 0.07 * std::sin(1.7 * along + z) + 0.05 * rng.normal();
    const double x = g.x0 + along * ux - (lateral + rough) * uy;
    const double y = g.y0 + along * uy + (lateral + rough) * ux;
    for (const Gallery& other : kGalleries) {
      if (&other != &g && z > 0.05 && inside(other, x, y, 0.25)) return;
    }
    out.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
  };
  for (double s = 0.0; s < length; s += kStep_m) {
    for (double a = -half; a < half; a += 1.6 * kStep_m) add(s, a, 0.03 * rng.normal());
    const double wall_m = 0.62 * g.height_m;
    for (double z = 0.0; z < wall_m; z += kStep_m) {
      for (const double side : {-half, half}) add(s, side, z);
    }
    const int arch = static_cast<int>(1.2 * g.width_m / kStep_m / 1.5);
    for (int i = 1; i < arch; ++i) {
      const double angle = std::numbers::pi * i / arch;
      add(s, half * std::cos(angle), wall_m + (g.height_m - wall_m) * std::sin(angle));
    }
  }
  for (const double s : {0.0, length}) {
    for (double a = -half; a < half; a += kStep_m) {
      for (double z = 0.0; z < 0.85 * g.height_m; z += kStep_m) add(s, a, z);
    }
  }
}

struct Stop {
  double t_s, x_m, y_m;
};

const std::array<std::vector<Stop>, kVehicles> kRoutes = {{
    {{0, 2, -0.6},
     {112, 2, -0.6},
     {140, 30, -0.5},
     {175, 72, -0.4},
     {205, 90, 4},
     {230, 92, -4},
     {270, 79, -1}},
    {{0, 4, 0.7},
     {4, 4, 0.7},
     {62, 57.5, 0.6},
     {68, 58, -2},
     {98, 58, -4},
     {200, 58, -4},
     {240, 58, -34},
     {270, 58, -34}},
    {{0, 0, 0.2},
     {8, 0, 0.2},
     {40, 29, 0.4},
     {48, 30, 4},
     {88, 30, 41},
     {150, 30, 12},
     {172, 33, 0.5},
     {186, 44, 0},
     {270, 44, 0}},
}};

std::array<double, 2> place_at(const std::vector<Stop>& route, double t_s) {
  if (t_s <= route.front().t_s) return {route.front().x_m, route.front().y_m};
  for (std::size_t i = 1; i < route.size(); ++i) {
    if (t_s > route[i].t_s) continue;
    const Stop &a = route[i - 1], &b = route[i];
    const double u = (t_s - a.t_s) / (b.t_s - a.t_s);
    return {a.x_m + u * (b.x_m - a.x_m), a.y_m + u * (b.y_m - a.y_m)};
  }
  return {route.back().x_m, route.back().y_m};
}

/// True in the bare middle of a gallery, where the LiDAR is degenerate along it.
bool is_bare(double x_m, double y_m) {
  if (std::abs(y_m) < 2.0) {
    return x_m > 6 && x_m < 74 && std::abs(x_m - 30) > 7 && std::abs(x_m - 58) > 7;
  }
  return std::abs(y_m) > 8 && std::abs(y_m) < 33 && x_m < 70;
}

}  // namespace

std::vector<Point> mine_points() {
  Rng rng(7, "mine");
  std::vector<Point> out;
  for (const Gallery& g : kGalleries) add_gallery(g, rng, out);
  return out;
}

Pose pose_of(int vehicle, double t_s) {
  const auto& route = kRoutes[static_cast<std::size_t>(vehicle)];
  const auto [x, y] = place_at(route, t_s);
  Pose pose{.x_m = x, .y_m = y};
  // At standstill, a vehicle faces its later direction of travel.
  for (const double ahead_s : {0.8, 3.0, 30.0, 150.0}) {
    const auto [nx, ny] = place_at(route, t_s + ahead_s);
    if (std::hypot(nx - x, ny - y) < 0.05) continue;
    pose.yaw_rad = std::atan2(ny - y, nx - x);
    break;
  }
  const auto [nx, ny] = place_at(route, t_s + 1.0);
  pose.speed_mps = std::hypot(nx - x, ny - y);
  pose.at_rest = pose.speed_mps < 0.02;
  pose.degenerate = is_bare(x, y) && !pose.at_rest;
  pose.axis = std::abs(y) < 2.0 ? std::array{1.0, 0.0} : std::array{0.0, 1.0};
  return pose;
}

int anchor_at(double t_s) { return t_s < kFirstHandOver_s ? 0 : t_s < kSecondHandOver_s ? 1 : 2; }

}  // namespace rali::view_demo
