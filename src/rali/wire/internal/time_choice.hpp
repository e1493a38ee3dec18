#pragma once

#include "rali/base/result.hpp"
#include "rali/wire/internal/first_clouds.hpp"

namespace rali::wire::internal {

/// Finds the time field, its unit and reference, and the header's position in the scan; writes
/// them, the scan period and the findings D02, D03 into `format`. Leaves point_time kNone if no
/// field is usable.
/// @return the text for the summary
[[nodiscard]] Result<std::string> choose_time(const FirstClouds& first,
                                              const CloudFormatOptions& options,
                                              CloudFormat& format);

/// Decides whether times can be computed from the azimuth (after choose_time and choose_rings).
[[nodiscard]] std::string choose_azimuth(const FirstClouds& first,
                                         const CloudFormatOptions& options, CloudFormat& format);

/// A finding of the doctor about a cloud topic.
[[nodiscard]] Finding cloud_finding(std::string id, Severity severity, std::string text,
                                    std::string effect, std::string remedy);

}  // namespace rali::wire::internal
