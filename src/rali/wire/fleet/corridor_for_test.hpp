#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "rali/base/rng.hpp"
#include "rali/fleet/facts/facts.hpp"

namespace rali::wire {

/// The empty corridor of algorithms_fleet 11.3, 4 m x 3 m, seen by 16 rings of 1800 rays with 2 cm
/// of noise from 0.9 m above its floor and 0.1 m off its middle; a door recess of 0.3 m in both
/// walls every 5 m. Averaged in cubes of leaf_m; no surface lies on a border of cubes, where noise
/// would count it twice.
inline fleet::PointArrays corridor_points(double leaf_m, bool with_intensity) {
  constexpr double kHalfWidth_m = 2.0, kFloor_m = -0.9, kCeiling_m = 2.1, kFar_m = 100.0;
  const auto range = [](double x, double y, double z) {
    double wall = std::numeric_limits<double>::infinity();
    if (std::abs(y) > 1e-9) {
      const double half_m = kHalfWidth_m - std::copysign(0.1, y);
      wall = half_m / std::abs(y);
      const double along = std::fmod(std::abs(wall * x) + 0.5, 5.0);
      if (along < 1.0) wall = (half_m + 0.3) / std::abs(y);
    }
    if (z < -1e-9) wall = std::min(wall, kFloor_m / z);
    if (z > 1e-9) wall = std::min(wall, kCeiling_m / z);
    return wall;
  };

  struct Cell {
    double x = 0.0, y = 0.0, z = 0.0, n = 0.0;
  };

  std::map<std::array<long, 3>, Cell> cells;
  Rng rng(24);
  for (int ring = 0; ring < 16; ++ring) {
    const double elevation = (-15.0 + 2.0 * ring) * std::numbers::pi / 180.0;
    for (int k = 0; k < 1800; ++k) {
      const double azimuth = (0.2 * k + 0.05) * std::numbers::pi / 180.0;
      const double x = std::cos(elevation) * std::cos(azimuth);
      const double y = std::cos(elevation) * std::sin(azimuth);
      const double z = std::sin(elevation);
      double r = range(x, y, z);
      if (r > kFar_m) continue;
      r += 0.02 * rng.normal();
      const auto cell = [leaf_m, r](double u) { return std::lround(std::floor(u * r / leaf_m)); };
      Cell& c = cells[{cell(x), cell(y), cell(z)}];
      c.x += x * r;
      c.y += y * r;
      c.z += z * r;
      c.n += 1.0;
    }
  }
  fleet::PointArrays points;
  for (const auto& [key, c] : cells) {
    points.push_back(static_cast<float>(c.x / c.n), static_cast<float>(c.y / c.n),
                     static_cast<float>(c.z / c.n));
    if (with_intensity) {
      const double paint = 60.0 + 20.0 * std::sin(0.5 * c.x / c.n) + 8.0 * rng.normal();
      points.intensity.push_back(static_cast<std::uint8_t>(std::clamp(paint, 0.0, 255.0)));
    }
  }
  return points;
}

inline fleet::KeyframePoints corridor_keyframe(double leaf_m, bool with_intensity) {
  fleet::KeyframePoints keyframe;
  keyframe.points = fleet::PackedPoints(corridor_points(leaf_m, with_intensity));
  return keyframe;
}

}  // namespace rali::wire
