#pragma once

#include <optional>
#include <span>
#include <string>

#include "rali/base/time.hpp"

namespace rali::drive {

/// Why inertial data are of no use for these scans, as a sentence without its end: they come less
/// than twice per scan, or lie wholly before or after all scans. Empty if they may be of use, or if
/// there are too few to decide.
/// @param scans, imu stamps on one clock, in any order
[[nodiscard]] std::optional<std::string> unfit_inertial(std::span<const Time> scans,
                                                        std::span<const Time> imu);

}  // namespace rali::drive
