#pragma once

#include <optional>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/fleet/centre/estimate.hpp"
#include "rali/fleet/centre/fleet_settings.hpp"
#include "rali/fleet/facts/facts.hpp"
#include "rali/fleet/path/vehicle_path.hpp"

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

/// The temporary centre of the fleet: makes one map of all vehicles from their facts (paper,
/// "Global optimisation"; algorithms_fleet 7 to 9). Which vehicle it runs on is nothing to it: the
/// same facts give the same estimate, in whatever order they come.
class Centre {
 public:
  Centre(const FleetSettings& settings, FleetKnowledge knowledge);

  /// Facts of which there is more than one of the same key are to be sorted out before.
  void add(const Fact& fact);

  /// Joins the frames, looks for loops and solves for everything that is known so far.
  [[nodiscard]] FleetEstimate estimate(Executor& executor) const;

  [[nodiscard]] const std::vector<VehiclePath>& paths() const { return paths_; }

 private:
  FleetSettings settings_;
  FleetKnowledge knowledge_;
  std::vector<VehiclePath> paths_;  ///< by vehicle
};

}  // namespace rali::fleet
