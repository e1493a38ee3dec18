#pragma once

#include <cmath>
#include <vector>

#include "rali/base/rng.hpp"
#include "rali/fleet/frames/hypotheses.hpp"

namespace rali::fleet {

inline constexpr StreamKey kTag{VehicleId{2}, 0};
inline constexpr StreamKey kAnchor{VehicleId{1}, 0};

/// Settings of the worked examples: the plane, no drift, no offset, every range counts.
inline InitSettings plain_settings() {
  InitSettings s;
  s.bias_sigma_m = 0.0;
  s.drift.scale = s.drift.yaw_deg_per_sqrt_m = s.drift.tilt_deg = 0.0;
  s.track.spacing_m = s.track.still_m = 0.0;
  return s;
}

/// Ranges at 1 s intervals; y with one entry is at standstill.
inline PairTrack track_of(const std::vector<geometry::Vec2>& x,
                          const std::vector<geometry::Vec2>& y, const std::vector<double>& ranges,
                          const InitSettings& settings, double sigma_m = 0.07) {
  PairTrack track(kTag, kAnchor, settings.track);
  for (std::size_t i = 0; i < x.size(); ++i) {
    RangeObservation o;
    o.t = Time::from_s(static_cast<double>(i));
    o.x_a_m.head<2>() = x[i];
    o.y_b_m.head<2>() = y[y.size() == 1 ? 0 : i];
    o.range_m = ranges[i];
    o.sigma_m = sigma_m;
    track.add(o);
  }
  return track;
}

/// Exact ranges of a transform.
inline std::vector<double> exact_ranges(const std::vector<geometry::Vec2>& x,
                                        const std::vector<geometry::Vec2>& y, const YawPose& T) {
  std::vector<double> out;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const geometry::Vec3 p = T * geometry::Vec3(x[i].x(), x[i].y(), 0.0);
    const geometry::Vec2& q = y[y.size() == 1 ? 0 : i];
    out.push_back((p.head<2>() - q).norm());
  }
  return out;
}

/// Points each `step_m` along straight lines.
inline std::vector<geometry::Vec2> along(const std::vector<geometry::Vec2>& corners,
                                         double step_m) {
  std::vector<geometry::Vec2> out = {corners.front()};
  for (std::size_t k = 1; k < corners.size(); ++k) {
    const geometry::Vec2 path = corners[k] - corners[k - 1];
    const int n = std::max(1, static_cast<int>(std::lround(path.norm() / step_m)));
    for (int i = 1; i <= n; ++i) out.push_back(corners[k - 1] + path * i / n);
  }
  return out;
}

}  // namespace rali::fleet
