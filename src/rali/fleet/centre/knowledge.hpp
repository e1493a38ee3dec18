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

/// What a pair of radios measures too much, where somebody calibrated it.
struct GivenBias {
  VehicleId a, b;
  double bias_m = 0.0;
};

/// What users know of the fleet beforehand.
struct FleetKnowledge {
  std::vector<GivenStart> starts;
  std::vector<GivenBias> biases;
  bool common_clock = true;  ///< false: recorded on other days, joined by places alone
};

}  // namespace rali::fleet
