#include "rali/ranging/range_gate.hpp"

#include <cmath>

#include "rali/geometry/robust.hpp"

namespace rali::ranging {

double one_sided_weight(double d, const GateSettings& settings) {
  if (d <= 0.0) return geometry::cauchy_weight(d, settings.shorter_scale);
  const double w = geometry::cauchy_weight(d, settings.longer_scale);
  return w * w;
}

GateDecision gate(double nu_m, double S_m2, double sigma_m, bool clear,
                  const GateSettings& settings) {
  GateDecision out;
  // Written so that NaN stays outside.
  if (!(S_m2 > 0.0 && std::isfinite(S_m2) && std::isfinite(nu_m) && sigma_m > 0.0)) return out;
  out.d = nu_m / std::sqrt(S_m2);
  out.inside = out.d * out.d <= settings.chi2;
  if (!out.inside) return out;
  const bool one_sided = !clear || std::abs(out.d) > settings.one_sided_above;
  out.weight =
      one_sided ? one_sided_weight(out.d, settings) : geometry::huber_weight(out.d, settings.huber);
  out.R_m2 = sigma_m * sigma_m / out.weight;
  return out;
}

}  // namespace rali::ranging
