#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/base/rng.hpp"
#include "rali/base/settings.hpp"

namespace rali::scenario {

/// Faults that can be injected into a recording.
enum class FaultKind {
  kDrop,         ///< half of the scans and inertial samples are missing, at random
  kGap,          ///< no LiDAR and IMU messages
  kClockJump,    ///< the vehicle's clock is 1 s ahead (set forward at T0, back at T1)
  kNan,          ///< a third of the points are NaN
  kCover,        ///< dust around the LiDAR: most rays end within a metre
  kTimeField,    ///< the time of every point is 0
  kImuScale,     ///< rates and accelerations 5 % too large
  kImuSaturate,  ///< rates are clipped at 0.3 rad/s, accelerations at 11 m/s^2
  kUwbBias,      ///< ranges of the vehicle are 0.5 m too long
  kUwbOff,       ///< the vehicle has no ranges
  kRadioLoss,    ///< the vehicle has no data link
  kCutFile       ///< the recording is truncated at T0, in the middle of a record
};
inline constexpr ChoiceNames<12> kFaultNames{"drop",     "gap",        "clock_jump", "nan",
                                             "cover",    "time_field", "imu_scale",  "imu_saturate",
                                             "uwb_bias", "uwb_off",    "radio_loss", "cut_file"};

inline constexpr double kFaultClockJump_s = 1.0;
inline constexpr double kFaultDropFraction = 0.5;
inline constexpr double kFaultNanFraction = 1.0 / 3.0;
inline constexpr double kFaultCoverFrom_m = 0.4;
inline constexpr double kFaultCoverDepth_m = 0.4;
inline constexpr double kFaultImuScale = 1.05;
inline constexpr double kFaultGyroLimit_radps = 0.3;
inline constexpr double kFaultAccelLimit_mps2 = 11.0;
inline constexpr double kFaultUwbBias_m = 0.5;

/// One fault of one vehicle, from t0_s until before t1_s after the start of the recording.
struct Fault {
  FaultKind kind = FaultKind::kDrop;
  int vehicle = 0;  ///< from 0: "v1" is 0
  double t0_s = 0.0;
  double t1_s = 0.0;
};

/// `KIND:VEHICLE@T0-T1`, e.g. "gap:v2@30-35"; for cut_file `KIND:VEHICLE@T0`. "all" means every
/// vehicle and gives one fault each.
/// @param vehicles  number of vehicles: v1, v2, ...
/// Errors: kUsage, one sentence with the fault and the allowed values.
[[nodiscard]] Result<std::vector<Fault>> parse_fault(std::string_view text, int vehicles);

/// Parses all texts, in order.
[[nodiscard]] Result<std::vector<Fault>> parse_faults(const std::vector<std::string>& texts,
                                                      int vehicles);

/// How deep a ray gets into dust: exponentially distributed.
[[nodiscard]] double cover_depth_m(Rng& chance);

/// The fault in command line syntax.
[[nodiscard]] std::string fault_text(const Fault& fault);

}  // namespace rali::scenario
