// Feeds a vehicle with scans of a bare tunnel, made here: target rali::core, no files. The tunnel
// has no features along x, so that the LiDAR cannot observe that direction.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <variant>

#include <rali/vehicle.hpp>

namespace {

/// A scan of 16 rings inside a tunnel 4 m wide and 3 m high, from the middle, 1 m above the ground.
rali::Scan tunnel_scan(std::int64_t stamp_ns) {
  rali::Scan scan;
  scan.stamp_ns = stamp_ns;
  scan.rings = 16;
  for (int column = 0; column < 360; ++column) {
    for (int ring = 0; ring < 16; ++ring) {
      const double azimuth = column * 3.14159265358979 / 180.0;
      const double elevation = (-15.0 + 2.0 * ring) * 3.14159265358979 / 180.0;
      const double x = std::cos(elevation) * std::cos(azimuth);
      const double y = std::cos(elevation) * std::sin(azimuth);
      const double z = std::sin(elevation);
      const double to_wall = std::abs(y) > 1e-9 ? 2.0 / std::abs(y) : 1e9;
      const double to_ground = z < -1e-9 ? 1.0 / -z : z > 1e-9 ? 2.0 / z : 1e9;
      const double range_m = std::min(to_wall, to_ground);
      scan.x_m.push_back(static_cast<float>(range_m * x));  // points out of range are dropped
      scan.y_m.push_back(static_cast<float>(range_m * y));
      scan.z_m.push_back(static_cast<float>(range_m * z));
      scan.ring.push_back(static_cast<std::uint16_t>(ring));
    }
  }
  return scan;
}

}  // namespace

int main() {
  rali::VehicleOptions options;
  options.name = "v1";
  options.has_imu = false;
  options.range_m = {0.4, 60.0};
  rali::Vehicle vehicle(options);
  for (int k = 0; k < 10; ++k) {
    for (const rali::Output& output : vehicle.step(tunnel_scan(k * 100'000'000LL))) {
      const auto* pose = std::get_if<rali::PoseEstimate>(&output);
      if (pose == nullptr) continue;
      const rali::Degeneracy& d = pose->degeneracy;
      std::printf("%.1f s degenerate=%d along (%.2f %.2f %.2f)\n", pose->t_s(),
                  d.degenerate ? 1 : 0, d.direction_odom.x(), d.direction_odom.y(),
                  d.direction_odom.z());
    }
  }
  return 0;
}
