#pragma once

#include <memory>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/sim/fleet/rover.hpp"

namespace rali::sim {

/// The vehicles of one world on a common clock. They give way to each other: who would run into
/// another stops and waits, of two whose ways cross the one with the higher number.
class FleetMotion {
 public:
  /// @param world  must have a start for each vehicle
  FleetMotion(const World& world, const MotionOptions& options, int vehicles, std::uint64_t seed);

  /// All vehicles by one tick.
  void step();

  /// All trajectories reach so far.
  [[nodiscard]] double time_s() const { return rovers_.front()->trajectory().duration_s(); }

  [[nodiscard]] int vehicles() const { return static_cast<int>(rovers_.size()); }

  [[nodiscard]] Rover& rover(int vehicle) { return *rovers_[static_cast<std::size_t>(vehicle)]; }

  [[nodiscard]] const Rover& rover(int vehicle) const {
    return *rovers_[static_cast<std::size_t>(vehicle)];
  }

  /// How long a vehicle has been standing for another one that is in its way.
  [[nodiscard]] double waited_s(int vehicle) const {
    return waited_s_[static_cast<std::size_t>(vehicle)];
  }

  [[nodiscard]] bool all_idle() const;

 private:
  [[nodiscard]] bool must_wait(const Rover& rover, std::size_t index) const;

  std::vector<std::unique_ptr<Rover>> rovers_;  ///< others keep pointers to their trajectories
  std::vector<double> waited_s_;
};

/// When a round of the script took place.
struct RoundTimes {
  int anchor = -1;       ///< who stood; -1: nobody had to
  double begin_s = 0.0;  ///< since the start; the vehicles leave
  double end_s = 0.0;    ///< all have arrived
};

/// Drives the rounds of the world: standstill_s standing, then each round until all have arrived,
/// pause_s between rounds and one second at the end. Errors (kUsage): vehicles that are in each
/// other's way for good.
[[nodiscard]] Result<std::vector<RoundTimes>> drive_rounds(FleetMotion& fleet, const World& world,
                                                           double standstill_s, double pause_s);

/// Seed of one vehicle's motion and sensors: the fleet's own for vehicle 0, so that more vehicles
/// change nothing for those there are.
[[nodiscard]] std::uint64_t vehicle_seed(std::uint64_t seed, int vehicle);

}  // namespace rali::sim
