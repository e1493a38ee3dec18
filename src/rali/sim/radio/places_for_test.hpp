#pragma once

#include <cmath>
#include <vector>

#include "rali/geometry/so3.hpp"
#include "rali/sim/radio/uwb_model.hpp"

// Positions, worlds and statistics that the tests of this folder share.
namespace rali::sim {

inline constexpr Time kTestStart = Time::from_ns(1'700'000'000'000'000'000);

inline Time at_s(double t_s) { return kTestStart + Duration::from_s(t_s); }

/// Radio at the origin of a vehicle's body.
inline RadioEnd end_at(int vehicle, const geometry::Vec3& p, double yaw_rad = 0.0) {
  RadioEnd end;
  end.vehicle = vehicle;
  end.T_world_body = {geometry::rotation_from_rpy(0.0, 0.0, yaw_rad), p};
  return end;
}

/// One small box far away: the ray caster rejects an empty mesh.
inline RayCaster open_air() {
  TriangleMesh mesh;
  mesh.add_box({0.0, 0.0, -900.0}, {1.0, 1.0, 1.0}, 0.0, 0.5);
  return RayCaster(mesh);
}

/// A wall of 0.2 m across the x axis at x = 5 m.
inline RayCaster one_wall() {
  TriangleMesh mesh;
  mesh.add_box({5.0, 0.0, -5.0}, {0.2, 40.0, 10.0}, 0.0, 0.5);
  return RayCaster(mesh);
}

struct Moments {
  double mean = 0.0, sd = 0.0;
};

inline Moments moments(const std::vector<double>& values) {
  Moments m;
  for (const double v : values) m.mean += v / static_cast<double>(values.size());
  for (const double v : values) m.sd += (v - m.mean) * (v - m.mean);
  m.sd = std::sqrt(m.sd / static_cast<double>(values.size()));
  return m;
}

}  // namespace rali::sim
