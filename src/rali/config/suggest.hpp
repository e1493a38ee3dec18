#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace rali::config {

/// The candidate most similar to `word`; empty if none is similar. Ties: the first.
[[nodiscard]] std::string nearest_name(std::string_view word,
                                       const std::vector<std::string>& candidates);

/// "Did you mean 'voxel_m'?" or "Known here: a, b, c." or "".
[[nodiscard]] std::string suggestion(std::string_view word,
                                     const std::vector<std::string>& candidates);

}  // namespace rali::config
