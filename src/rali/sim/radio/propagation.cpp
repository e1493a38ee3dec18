#include "rali/sim/radio/propagation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include <Eigen/Geometry>

namespace rali::sim {

using geometry::Vec3;

double path_loss_db(double distance_m, double exponent) {
  return 10.0 * exponent * std::log10(std::max(distance_m, 0.1));
}

double reported_power_dbm(double true_dbm, double ceiling_dbm) {
  // In a form that does not overflow: the smaller power minus the loss by the other.
  const double low = std::min(true_dbm, ceiling_dbm);
  const double high = std::max(true_dbm, ceiling_dbm);
  return low - 10.0 * std::log10(1.0 + std::pow(10.0, (low - high) / 10.0));
}

double loss_probability(double power_dbm, double sensitivity_dbm) {
  return 1.0 / (1.0 + std::exp(power_dbm - sensitivity_dbm));
}

Multipath multipath_between(const RayCaster& world, const Vec3& a, const Vec3& b,
                            const MultipathOptions& o) {
  const double distance = (b - a).norm();
  if (distance < 1e-3 || o.reflection <= 0.0) return {};
  const Vec3 along = (b - a) / distance;
  // The side direction is horizontal unless the line is steep.
  const Vec3 reference = std::abs(along.z()) < 0.9 ? Vec3::UnitZ() : Vec3::UnitX();
  const Vec3 side = along.cross(reference).normalized();
  const Vec3 up = side.cross(along);
  const std::array<Vec3, 4> directions{side, Vec3(-side), up, Vec3(-up)};
  constexpr double kReach_m = 30.0;
  Multipath sum;
  std::complex<double> field(1.0, 0.0);
  for (const Vec3& direction : directions) {
    const Hit hit = world.cast(0.5 * (a + b), direction, kReach_m);
    if (hit.range_m <= 0.0F) continue;
    const double height = static_cast<double>(hit.range_m);
    const double length = std::hypot(distance, 2.0 * height);
    const double excess = length - distance;
    const double strength = o.reflection * distance / length;
    const double phase = 2.0 * std::numbers::pi * excess / o.wavelength_m + std::numbers::pi;
    field += std::polar(strength, phase);
    const double overlap = std::exp(-excess / o.pulse_m);
    sum.range_error_m += o.error_m * strength * overlap * std::cos(phase);
  }
  sum.power_db = 20.0 * std::log10(std::max(std::abs(field), 0.05));
  return sum;
}

double Wandering::next(Time t, double tau_s, Rng& rng) {
  const double draw = rng.normal();
  if (!started_) {
    value_ = draw;
    started_ = true;
  } else {
    const double keep = std::exp(-std::max(0.0, seconds_between(last_, t)) / tau_s);
    value_ = keep * value_ + std::sqrt(1.0 - keep * keep) * draw;
  }
  last_ = t;
  return value_;
}

bool Burst::next(Time t, double fraction, double length_s, Rng& rng) {
  // Rates: off 1/length, on fraction/((1 - fraction) length); the probability after dt in closed
  // form.
  const double draw = rng.uniform();
  double chance = fraction;
  if (started_ && fraction < 1.0) {
    const double rate = 1.0 / (length_s * (1.0 - fraction));
    const double keep = std::exp(-rate * std::max(0.0, seconds_between(last_, t)));
    chance += ((on_ ? 1.0 : 0.0) - fraction) * keep;
  }
  const bool was_on = started_ && on_;
  on_ = draw < chance;
  began_ = on_ && !was_on;
  started_ = true;
  last_ = t;
  return on_;
}

}  // namespace rali::sim
