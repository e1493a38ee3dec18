#include "rali/ranging/path_fit.hpp"

#include "rali/ranging/range_gate.hpp"

namespace rali::ranging {

bool fits_path(double nu_m, double sigma_m, double path_sigma_m, const GateSettings& settings) {
  const double S_m2 = sigma_m * sigma_m + path_sigma_m * path_sigma_m;
  return gate(nu_m, S_m2, sigma_m, true, settings).inside;
}

double bias_sigma_m(const BiasSettings& settings, bool calibrated) {
  constexpr double kCalibratedFraction = 0.2;
  return (calibrated ? kCalibratedFraction : 1.0) * settings.sigma_m;
}

}  // namespace rali::ranging
