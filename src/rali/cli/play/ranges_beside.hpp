#pragma once

#include <memory>
#include <string>

#include "rali/base/result.hpp"
#include "rali/io/message_source.hpp"

namespace rali::cli {

/// A recording with the ranges of a CSV file inserted between its messages, as published by one
/// vehicle's radio: rali_msgs/Range on /uwb/ranges, each some milliseconds after its stamp.
/// @param vehicle only rows with this vehicle at one end are used
/// Errors: kInput (no such file, a column missing, no row of this vehicle)
[[nodiscard]] Result<std::unique_ptr<io::MessageSource>> with_ranges(
    std::unique_ptr<io::MessageSource> recording, const std::string& csv,
    const std::string& vehicle);

}  // namespace rali::cli
