#pragma once

#include "rali/base/result.hpp"
#include "rali/wire/internal/first_clouds.hpp"

namespace rali::wire::internal {

/// Refuses clouds that lie almost wholly beyond the range limits where another unit would put them
/// within: no point of them would be used. Errors: kInput, with the unit that the values suggest.
[[nodiscard]] Status check_unit(const FirstClouds& first, const CloudFormatOptions& options);

}  // namespace rali::wire::internal
