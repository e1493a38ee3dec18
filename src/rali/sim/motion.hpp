#pragma once

#include "rali/base/rng.hpp"
#include "rali/base/settings.hpp"
#include "rali/sim/jolts.hpp"
#include "rali/sim/route.hpp"
#include "rali/sim/trajectory.hpp"

namespace rali::sim {

enum class Carrier { kCart, kHandheld, kDrone };
inline constexpr ChoiceNames<3> kCarrierNames{"cart", "handheld", "drone"};

/// Parameters of the vehicle's motion along its route.
struct MotionOptions {
  Carrier carrier = Carrier::kCart;
  double speed_mps = 1.4;  ///< on straights, before speed_factor; varies by +-30 %
  double speed_factor = 1.0;
  double standstill_s = 3.0;        ///< standstill at the start; 0: the recording starts in motion
  double acceleration_mps2 = 0.6;   ///< along the path
  double yaw_rate_max_radps = 0.7;  ///< slows down in bends
  double body_height_m = 0.25;      ///< of the body's origin above the ground
  double suspension = 1.0;          ///< scale of the jolts; 0: rigid
  double wander_m = 0.15;           ///< lateral swing about the route
  JoltOptions jolts;

  template <class V>
  void visit(V& v) {
    v.choice("carrier", carrier, kCarrierNames, "what carries the sensors");
    v("speed_mps", speed_mps, 0.1, 10.0, "speed on straights");
    v("speed_factor", speed_factor, 0.1, 5.0, "scale of all speeds");
    v("standstill_s", standstill_s, 0.0, 60.0, "standing time at the start, 0 starts in motion");
    v("acceleration_mps2", acceleration_mps2, 0.05, 5.0, "acceleration along the way");
    v("yaw_rate_max_radps", yaw_rate_max_radps, 0.1, 3.0, "fastest turn");
    v("body_height_m", body_height_m, 0.0, 3.0, "height of the body above the ground");
    v("wander_m", wander_m, 0.0, 2.0, "swings to the sides of the route");
    v("suspension", suspension, 0.0, 3.0, "scale of the suspension's jolts");
    v.group("jolts", jolts, "steps of the body shorter than an inertial sample");
  }
};

/// Speed along a route that respects the limits of bends and acceleration and ends at zero.
class SpeedProfile {
 public:
  /// @param from_rest  starts at zero speed too
  SpeedProfile(const Route& route, const MotionOptions& options, bool from_rest, Rng& rng);

  /// Speed [m/s] at arc length s [m].
  [[nodiscard]] double at(double s_m) const;

 private:
  std::vector<double> v_mps_;  ///< at every Route::kStep_m
};

/// Drives `route` from its start to its end. Same seed: same motion.
[[nodiscard]] Trajectory make_trajectory(const Route& route, const MotionOptions& options,
                                         std::uint64_t seed);

}  // namespace rali::sim
