#pragma once

#include <vector>

#include "rali/base/ids.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::fleet {

/// A start pose measured by hand: the first pose of one vehicle in that of another, both levelled
/// and with their headings along x.
struct GivenStart {
  VehicleId relative_to, vehicle;
  geometry::SE3 T_relative_vehicle;
  double sigma_m = 0.2;
  double sigma_rad = 0.05;
};

/// Calibrated bias of a pair of radios.
struct GivenBias {
  VehicleId a, b;
  double bias_m = 0.0;
};

/// Prior knowledge of the users about the fleet.
struct FleetKnowledge {
  std::vector<GivenStart> starts;
  std::vector<GivenBias> biases;
  bool common_clock = true;  ///< false: recorded at different times, joined by places alone
};

}  // namespace rali::fleet
