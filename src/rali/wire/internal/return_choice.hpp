#pragma once

#include <string>

#include "rali/wire/internal/first_clouds.hpp"

namespace rali::wire::internal {

/// If points carry a return type and one laser pulse made several points, chooses the types to
/// leave out, so that each pulse keeps one (options.returns == kOne).
/// @return the text for the summary; empty for single returns
[[nodiscard]] std::string choose_returns(const FirstClouds& first,
                                         const CloudFormatOptions& options, CloudFormat& format);

}  // namespace rali::wire::internal
