#pragma once

#include <optional>
#include <span>
#include <string>

#include "rali/base/time.hpp"

namespace rali::drive {

/// Why inertial data are of no use for these sweeps, as a sentence without its end: they come less
/// than twice per sweep, or lie wholly before or after all sweeps. Empty if they may be of use, or
/// if there are too few to tell.
/// @param sweeps, imu  stamps on one clock, in any order
[[nodiscard]] std::optional<std::string> unfit_inertial(std::span<const Time> sweeps,
                                                        std::span<const Time> imu);

}  // namespace rali::drive
