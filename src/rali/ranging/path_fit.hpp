#pragma once

#include "rali/ranging/excess_watch.hpp"
#include "rali/ranging/settings.hpp"

namespace rali::ranging {

/// Whether a range belongs to a path that was solved with all ranges: what did not fit a wrong path
/// may fit the right one, and the other way round. Ranges of one pair in the order of time.
/// @param watch of the pair, begun with this look
/// @param nu_m measured less predicted  @param sigma_m of the range
/// @param path_sigma_m doubt about the path
[[nodiscard]] bool fits_path(ExcessWatch& watch, Time t, double nu_m, double sigma_m,
                             double path_sigma_m, const GateSettings& settings);

/// Sigma of a pair's bias beforehand. One that somebody calibrated still wanders by some of what it
/// was.
[[nodiscard]] double bias_sigma_m(const BiasSettings& settings, bool calibrated);

}  // namespace rali::ranging
