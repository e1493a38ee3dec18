#pragma once

#include "rali/base/result.hpp"
#include "rali/wire/internal/first_clouds.hpp"

namespace rali::wire::internal {

/// Refuses clouds of which almost all points lie beyond the range limits, but within them in
/// another unit: no point would be used. Errors: kInput, with the unit that the values suggest.
[[nodiscard]] Status check_unit(const FirstClouds& first, const CloudFormatOptions& options);

}  // namespace rali::wire::internal
