#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/base/settings.hpp"

namespace rali::scenario {

/// What can go wrong with a recording.
enum class FaultKind {
  kDrop,         ///< half of the sweeps and inertial samples are missing, at random
  kGap,          ///< nothing of LiDAR and IMU is recorded
  kClockJump,    ///< the vehicle's clock is 1 s ahead (set forward at T0, back at T1)
  kNan,          ///< a third of the points are not a number
  kTimeField,    ///< the time of every point is 0
  kImuScale,     ///< rates and accelerations 5 % too large
  kImuSaturate,  ///< rates beyond 0.3 rad/s and accelerations beyond 11 m/s^2 are cut off
  kUwbBias,      ///< ranges of the vehicle are 0.5 m too long
  kUwbOff,       ///< no ranges of the vehicle
  kRadioLoss,    ///< no data link of the vehicle
  kCutFile       ///< the recording breaks off at T0, in the middle of a record
};
inline constexpr ChoiceNames<11> kFaultNames{"drop",       "gap",        "clock_jump",   "nan",
                                             "time_field", "imu_scale",  "imu_saturate", "uwb_bias",
                                             "uwb_off",    "radio_loss", "cut_file"};

inline constexpr double kFaultClockJump_s = 1.0;
inline constexpr double kFaultDropShare = 0.5;
inline constexpr double kFaultNanShare = 1.0 / 3.0;
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

/// `KIND:VEHICLE@T0-T1`, e.g. "gap:v2@30-35"; of cut_file `KIND:VEHICLE@T0`. "all" stands for
/// every vehicle and gives one fault each.
/// @param vehicles  how many there are: v1, v2, ...
/// Errors: kUsage, one sentence that names what is wrong and what is allowed.
[[nodiscard]] Result<std::vector<Fault>> parse_fault(std::string_view text, int vehicles);

/// All of them, in order.
[[nodiscard]] Result<std::vector<Fault>> parse_faults(const std::vector<std::string>& texts,
                                                      int vehicles);

/// As it is written on the command line.
[[nodiscard]] std::string fault_text(const Fault& fault);

}  // namespace rali::scenario
