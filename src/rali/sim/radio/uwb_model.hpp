#pragma once

#include <array>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rali/base/rng.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/sensor/range_sample.hpp"
#include "rali/sim/radio/obstruction.hpp"
#include "rali/sim/radio/propagation.hpp"
#include "rali/sim/radio/uwb_options.hpp"

namespace rali::sim {

/// One end of a radio exchange.
struct RadioEnd {
  int vehicle = 0;  ///< becomes VehicleId
  int antenna = 0;  ///< index in the vehicle's list
  geometry::SE3 T_world_body;
  geometry::Vec3 p_body_antenna = geometry::Vec3::Zero();

  [[nodiscard]] geometry::Vec3 position() const { return T_world_body * p_body_antenna; }
};

/// Ground truth of one exchange, and its obstructions.
struct RangeTruth {
  Time t;                   ///< true time of the exchange
  double distance_m = 0.0;  ///< between the antennas
  bool obstructed = false;  ///< by walls, vehicles or persons
  double bias_m = 0.0;      ///< pair + both antennas' angle + distance: the systematic part
  double excess_m = 0.0;    ///< walls, bursts, reflections: the part that depends on the position
  bool outlier = false;     ///< a gross error was added
};

/// Bias of an antenna by the direction to the other end: two harmonics of azimuth,
/// c1 cos(a) + s1 sin(a) + c2 cos(2a) + s2 sin(2a) [m].
struct AntennaPattern {
  double c1 = 0.0, s1 = 0.0, c2 = 0.0, s2 = 0.0;

  [[nodiscard]] double at(double azimuth_rad) const;
};

/// Two-way ranging between the antennas of a fleet. Each pair of antennas has its own random
/// streams: other vehicles or exchanges do not change its data.
class UwbModel {
 public:
  /// @param start  time at which the stamps have no drift; empty: the first exchange
  UwbModel(const UwbOptions& options, int vehicles, std::uint64_t seed,
           std::optional<Time> start = std::nullopt);

  /// One exchange at true time t; call in time order for each pair. Symmetric: the ends may be
  /// swapped, the sample is from `a` to `b` and stamped by the clock of `a`. Empty if it was lost;
  /// last_truth() is then valid too.
  /// @param bodies  vehicles and persons that may obstruct the signal, without the two ends
  [[nodiscard]] std::optional<sensor::RangeSample> measure(Time t, const RadioEnd& a,
                                                           const RadioEnd& b,
                                                           const RayCaster& world,
                                                           std::span<const RadioBody> bodies = {});

  [[nodiscard]] const RangeTruth& last_truth() const { return truth_; }

  /// Constant part of the bias of a pair of antennas, in either order.
  [[nodiscard]] double pair_bias_m(int vehicle_a, int antenna_a, int vehicle_b,
                                   int antenna_b) const;
  [[nodiscard]] AntennaPattern pattern(int vehicle, int antenna) const;

  /// Error of a vehicle's radio stamps at time t, without jitter.
  [[nodiscard]] double stamp_error_s(int vehicle, Time t) const;

  [[nodiscard]] const UwbOptions& options() const { return options_; }

 private:
  using PairKey = std::array<int, 4>;  ///< vehicle and antenna of the lower end, then of the other

  /// State of a pair of antennas.
  struct Link {
    Link(std::uint64_t seed, const std::string& name);

    Rng white, slow, burst, excess, rare, power, fade, stamp;
    Wandering slow_error, fading;
    Burst missed;
    double burst_excess = 0.0;  ///< of the current burst, in units of its mean
    double pair_bias_sd = 0.0;  ///< in units of its sd
  };

  struct Clock {
    double offset_s = 0.0;
    double drift = 0.0;
  };

  struct Power {
    double total_dbm = 0.0;       ///< true received power
    double first_path_dbm = 0.0;  ///< of the direct path
  };

  [[nodiscard]] static PairKey key_of(int vehicle_a, int antenna_a, int vehicle_b, int antenna_b);
  [[nodiscard]] Link& link_of(const PairKey& key);
  [[nodiscard]] double systematic_bias_m(const Link& link, const RadioEnd& a, const RadioEnd& b,
                                         double distance_m) const;
  [[nodiscard]] double loss_db(const Obstruction& between) const;
  [[nodiscard]] double excess_m(Link& link, Time t, const Obstruction& between) const;
  [[nodiscard]] double noise_m(Link& link, Time t, double distance_m, double blocked);
  [[nodiscard]] Power power_of(Link& link, Time t, double distance_m, double loss_db,
                               double echoes_db) const;

  UwbOptions options_;
  std::uint64_t seed_;
  std::vector<Clock> clocks_;
  std::map<PairKey, Link> links_;
  std::optional<Time> start_;
  RangeTruth truth_;
};

}  // namespace rali::sim
