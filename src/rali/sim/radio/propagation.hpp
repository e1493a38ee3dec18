#pragma once

#include "rali/base/rng.hpp"
#include "rali/base/time.hpp"
#include "rali/geometry/types.hpp"
#include "rali/sim/ray_caster.hpp"

namespace rali::sim {

/// Path loss relative to 1 m: 10 n log10(d). Constant below 0.1 m.
[[nodiscard]] double path_loss_db(double distance_m, double exponent);

/// Power reported by a receiver that saturates at `ceiling_dbm`: 1 / (1/p + 1/ceiling) in mW.
[[nodiscard]] double reported_power_dbm(double true_dbm, double ceiling_dbm);

/// Probability that a packet is lost: 1/2 at the sensitivity, 12 % at 2 dB more.
[[nodiscard]] double loss_probability(double power_dbm, double sensitivity_dbm);

/// Effect of reflections from the surfaces beside, above and below the line of sight.
struct Multipath {
  double range_error_m = 0.0;  ///< from reflections within the pulse of the direct path
  double power_db = 0.0;       ///< of all paths relative to the direct one alone
};

struct MultipathOptions {
  double error_m = 0.05;  ///< per reflection as strong and as long as the direct path
  double pulse_m = 0.35;
  double reflection = 0.5;
  double wavelength_m = 0.075;  ///< 4 GHz
};

/// Four mirror images, located by rays to both sides, up and down from the middle of the line a-b.
/// Depends on the positions alone. Two stationary antennas have a constant error, moving ones a
/// quickly changing one; in corridors it grows with their distance.
[[nodiscard]] Multipath multipath_between(const RayCaster& world, const geometry::Vec3& a,
                                          const geometry::Vec3& b, const MultipathOptions& options);

/// Random process of mean 0 and sd 1 with correlation exp(-dt/tau) (Ornstein-Uhlenbeck). Exact
/// for any time step; takes one random number per step.
class Wandering {
 public:
  double next(Time t, double tau_s, Rng& rng);

 private:
  bool started_ = false;
  Time last_;
  double value_ = 0.0;
};

/// On-off process (two-state Markov process), on for `fraction` of the time and for `length_s` on
/// average; takes one random number per step. Exact for any time step.
class Burst {
 public:
  /// True while on. `began()` is true if it switched on in this step.
  bool next(Time t, double fraction, double length_s, Rng& rng);

  [[nodiscard]] bool began() const { return began_; }

 private:
  bool started_ = false;
  bool on_ = false;
  bool began_ = false;
  Time last_;
};

}  // namespace rali::sim
