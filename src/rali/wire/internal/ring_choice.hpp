#pragma once

#include <string>
#include <vector>

#include "rali/wire/internal/first_clouds.hpp"

namespace rali::wire::internal {

/// Elevations [rad, ascending] of a sensor with discrete lasers, found as clusters in the sample of
/// the first clouds; empty if they do not form 8 to 128 clear clusters.
[[nodiscard]] std::vector<float> find_elevations(const FirstClouds& first);

/// Decides the source of ring indices and the likely model; writes ring, ring_from, rings,
/// elevations, model and findings D06.
/// @return the text for the summary
[[nodiscard]] std::string choose_rings(const FirstClouds& first, const CloudFormatOptions& options,
                                       CloudFormat& format);

}  // namespace rali::wire::internal
