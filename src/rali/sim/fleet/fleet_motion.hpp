#pragma once

#include <memory>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/sim/fleet/rover.hpp"

namespace rali::sim {

/// The vehicles of one world on a common clock. A vehicle about to run into another one stops and
/// waits. If two paths cross, the vehicle with the higher number waits.
class FleetMotion {
 public:
  /// @param world  must have a start for each vehicle
  FleetMotion(const World& world, const MotionOptions& options, int vehicles, std::uint64_t seed);

  /// Advances all vehicles by one tick.
  void step();

  /// End of all trajectories so far.
  [[nodiscard]] double time_s() const { return rovers_.front()->trajectory().duration_s(); }

  [[nodiscard]] int vehicles() const { return static_cast<int>(rovers_.size()); }

  [[nodiscard]] Rover& rover(int vehicle) { return *rovers_[static_cast<std::size_t>(vehicle)]; }

  [[nodiscard]] const Rover& rover(int vehicle) const {
    return *rovers_[static_cast<std::size_t>(vehicle)];
  }

  /// How long a vehicle has been waiting for another one that blocks its path.
  [[nodiscard]] double waited_s(int vehicle) const {
    return waited_s_[static_cast<std::size_t>(vehicle)];
  }

  [[nodiscard]] bool all_idle() const;

 private:
  [[nodiscard]] bool must_wait(const Rover& rover, std::size_t index) const;

  std::vector<std::unique_ptr<Rover>> rovers_;  ///< sensors keep pointers to their trajectories
  std::vector<double> waited_s_;
};

/// Times of one scripted round.
struct RoundTimes {
  int anchor = -1;       ///< the stationary vehicle; -1: none
  double start_s = 0.0;  ///< since the start; the vehicles depart
  double end_s = 0.0;    ///< all have arrived
};

/// Drives the rounds of the world: standstill_s at standstill, then each round until all vehicles
/// have arrived, pause_s between rounds and one second at the end. Errors (kUsage): vehicles that
/// block each other for good.
[[nodiscard]] Result<std::vector<RoundTimes>> drive_rounds(FleetMotion& fleet, const World& world,
                                                           double standstill_s, double pause_s);

/// Seed of one vehicle's motion and sensors. Vehicle 0 uses the fleet's seed, and added vehicles do
/// not change the data of the existing ones.
[[nodiscard]] std::uint64_t vehicle_seed(std::uint64_t seed, int vehicle);

}  // namespace rali::sim
