#pragma once

#include "rali/ranging/settings.hpp"

namespace rali::ranging {

/// Whether a range is an inlier of a path that was solved with all ranges: an outlier of a wrong
/// path may be an inlier of the right one, and vice versa.
/// @param nu_m measured less predicted  @param sigma_m of the range
/// @param path_sigma_m sigma of the path
[[nodiscard]] bool fits_path(double nu_m, double sigma_m, double path_sigma_m,
                             const GateSettings& settings);

/// Prior sigma of a pair's bias. A calibrated bias still drifts by a fraction of its prior sigma.
[[nodiscard]] double bias_sigma_m(const BiasSettings& settings, bool calibrated);

}  // namespace rali::ranging
