#pragma once

#include "rali/ranging/settings.hpp"

namespace rali::ranging {

/// Result of the gate for one residual.
struct GateDecision {
  bool inside = false;
  double d = 0.0;       ///< residual divided by its predicted sd
  double weight = 0.0;  ///< in (0, 1]; 0 outside
  double R_m2 = 0.0;    ///< sigma^2 / weight, the variance to update with; 0 outside
};

/// Weight of a normalised residual d if the line of sight may be blocked, which only makes a range
/// longer: (1 + (d/1.5)^2)^-2 for d > 0, (1 + (d/2.5)^2)^-1 else (algorithms 4.3, step 5).
[[nodiscard]] double one_sided_weight(double d, const GateSettings& settings);

/// Steps 4 and 5 of algorithms 4.3. `nu_m`: measured less predicted, bias included; `S_m2`: its
/// variance H P H^T + sigma^2; `sigma_m`: of the range, as raised by signal and map; `clear`: that
/// neither of them raised it. Applied to all d, the one-sided weights would shorten a link in line
/// of sight by 0.3 sd; hence they apply to blocked ranges and large d only.
[[nodiscard]] GateDecision gate(double nu_m, double S_m2, double sigma_m, bool clear,
                                const GateSettings& settings);

}  // namespace rali::ranging
