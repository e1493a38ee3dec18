#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "rali/api/convert.hpp"

namespace rali::api {
namespace {

/// A revolution takes 0.2 s at most; sparse sensors and merged frames may take longer.
constexpr float kScanTimeMax_s = 10.0F;

Status check_length(const char* name, std::size_t n, std::size_t points) {
  if (n == points) return {};
  return fail(ErrorCode::kInput, "scan",
              fmt::format("{} has {} values for {} points", name, n, points),
              "Give one value per point, or none.");
}

Status check_lengths(const Scan& scan) {
  const std::size_t n = scan.size();
  if (Status s = check_length("y_m", scan.y_m.size(), n); !s) return s;
  if (Status s = check_length("z_m", scan.z_m.size(), n); !s) return s;
  if (!scan.intensity.empty()) {
    if (Status s = check_length("intensity", scan.intensity.size(), n); !s) return s;
  }
  if (!scan.dt_s.empty()) {
    if (Status s = check_length("dt_s", scan.dt_s.size(), n); !s) return s;
  }
  return scan.ring.empty() ? Status{} : check_length("ring", scan.ring.size(), n);
}

/// Which points are kept: finite, in range, with a plausible time.
std::vector<bool> usable(sensor::LidarScan& scan, const std::array<double, 2>& range_m) {
  std::vector<bool> keep(scan.size(), true);
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const double square_m2 = static_cast<double>(scan.x_m[i]) * static_cast<double>(scan.x_m[i]) +
                             static_cast<double>(scan.y_m[i]) * static_cast<double>(scan.y_m[i]) +
                             static_cast<double>(scan.z_m[i]) * static_cast<double>(scan.z_m[i]);
    const bool a_point = std::isfinite(square_m2) && square_m2 > 0.0;
    const bool in_range =
        square_m2 >= range_m[0] * range_m[0] && square_m2 <= range_m[1] * range_m[1];
    const bool in_time = scan.dt_s[i] >= 0.0F && scan.dt_s[i] <= kScanTimeMax_s;
    keep[i] = a_point && in_range && in_time;
    if (!a_point) {
      ++scan.dropped_nan;
    } else if (!in_range) {
      ++scan.dropped_range;
    } else if (!in_time) {
      ++scan.dropped_time;
    }
  }
  return keep;
}

template <class T>
void erase_dropped(const std::vector<bool>& keep, std::vector<T>& values) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (keep[i]) values[kept++] = values[i];
  }
  values.resize(kept);
}

}  // namespace

Result<sensor::LidarScan> inner_scan(Scan scan, const std::array<double, 2>& range_m) {
  if (Status s = check_lengths(scan); !s) return tl::make_unexpected(s.error());
  const std::size_t n = scan.size();
  sensor::LidarScan inner;
  inner.t_start = Time::from_ns(scan.stamp_ns);
  inner.has_point_times = !scan.dt_s.empty();
  inner.has_rings = !scan.ring.empty();
  inner.deskewed = scan.deskewed;
  inner.x_m = std::move(scan.x_m);
  inner.y_m = std::move(scan.y_m);
  inner.z_m = std::move(scan.z_m);
  inner.intensity = std::move(scan.intensity);
  inner.dt_s = std::move(scan.dt_s);
  inner.ring = std::move(scan.ring);
  inner.intensity.resize(n, 0.0F);
  inner.dt_s.resize(n, 0.0F);
  inner.ring.resize(n, 0);
  const std::vector<bool> keep = usable(inner, range_m);
  for (auto* values : {&inner.x_m, &inner.y_m, &inner.z_m, &inner.intensity, &inner.dt_s}) {
    erase_dropped(keep, *values);
  }
  erase_dropped(keep, inner.ring);
  std::uint16_t rings = 0;
  for (const std::uint16_t ring : inner.ring) {
    rings = std::max(rings, static_cast<std::uint16_t>(ring + 1));
  }
  if (inner.has_rings) inner.rings = std::max(scan.rings, rings);
  const float last_s =
      inner.dt_s.empty() ? 0.0F : *std::max_element(inner.dt_s.begin(), inner.dt_s.end());
  inner.t_end = inner.t_start + Duration::from_s(static_cast<double>(last_s));
  return inner;
}

Scan public_scan(const sensor::LidarScan& scan) {
  Scan result;
  result.stamp_ns = scan.t_start.ns;
  result.x_m = scan.x_m;
  result.y_m = scan.y_m;
  result.z_m = scan.z_m;
  result.intensity = scan.intensity;
  if (scan.has_point_times) result.dt_s = scan.dt_s;
  if (scan.has_rings) result.ring = scan.ring;
  result.rings = scan.rings;
  result.deskewed = scan.deskewed;
  return result;
}

}  // namespace rali::api
