#include "rali/sim/radio/uwb_model.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "rali/base/assert.hpp"

namespace rali::sim {

using geometry::Vec3;

namespace {

double exponential(Rng& rng) { return -std::log(1.0 - rng.uniform()); }

/// Azimuth of `to` in the body frame, about its z axis.
double azimuth_of(const RadioEnd& end, const Vec3& to) {
  const Vec3 d = end.T_world_body.R.transpose() * (to - end.position());
  return std::atan2(d.y(), d.x());
}

std::string vehicle_name(const char* what, int vehicle) {
  return fmt::format("{} {}", what, vehicle);
}

}  // namespace

UwbOptions UwbOptions::ideal() {
  UwbOptions o;
  o.sigma_m = o.sigma_per_m = o.slow_sigma_m = 0.0;
  o.pair_bias_m = o.pair_bias_sd_m = o.angle_bias_m = o.far_bias_m = 0.0;
  o.wall_index = 1.0;
  o.body_delay_m = o.blocked_sigma_m = 0.0;
  o.blocked_burst_fraction = o.clear_burst_fraction = 0.0;
  o.multipath_m = o.outlier_fraction = o.loss_fraction = 0.0;
  o.reflection = o.fading_db = o.power_noise_db = o.first_path_gap_db = o.resolution_m = 0.0;
  o.ceiling_dbm = 60.0;
  o.stamp_offset_s = o.stamp_drift_ppm = o.stamp_jitter_s = 0.0;
  return o;
}

UwbOptions UwbOptions::dw1000() {
  UwbOptions o;
  o.rate_hz = 7.0;
  o.sigma_m = 0.025;
  o.sigma_per_m = 0.0;
  o.slow_sigma_m = 0.02;
  o.pair_bias_m = 0.0;
  o.pair_bias_sd_m = 0.06;
  o.far_bias_m = 0.30;
  o.clear_burst_fraction = 0.0;
  o.fading_db = 2.5;
  o.outlier_fraction = 0.004;
  return o;
}

double AntennaPattern::at(double azimuth_rad) const {
  return c1 * std::cos(azimuth_rad) + s1 * std::sin(azimuth_rad) +
         c2 * std::cos(2.0 * azimuth_rad) + s2 * std::sin(2.0 * azimuth_rad);
}

UwbModel::Link::Link(std::uint64_t seed, const std::string& name)
    : white(seed, name + " white"),
      slow(seed, name + " slow"),
      burst(seed, name + " burst"),
      excess(seed, name + " excess"),
      rare(seed, name + " rare"),
      power(seed, name + " power"),
      fade(seed, name + " fade"),
      stamp(seed, name + " stamp") {
  Rng bias(seed, name + " bias");
  pair_bias_sd = bias.normal();
}

UwbModel::UwbModel(const UwbOptions& options, int vehicles, std::uint64_t seed,
                   std::optional<Time> start)
    : options_(options), seed_(seed), start_(start) {
  for (int v = 0; v < vehicles; ++v) {
    Rng rng(seed, vehicle_name("uwb clock", v));
    const double offset = rng.normal() * options_.stamp_offset_s;
    clocks_.push_back({offset, rng.normal() * options_.stamp_drift_ppm * 1e-6});
  }
}

UwbModel::PairKey UwbModel::key_of(int vehicle_a, int antenna_a, int vehicle_b, int antenna_b) {
  const std::pair<int, int> a{vehicle_a, antenna_a};
  const std::pair<int, int> b{vehicle_b, antenna_b};
  const auto& [low, high] = std::minmax(a, b);
  return {low.first, low.second, high.first, high.second};
}

namespace {

std::string link_name(const std::array<int, 4>& k) {
  return fmt::format("uwb {}.{}-{}.{}", k[0], k[1], k[2], k[3]);
}

}  // namespace

UwbModel::Link& UwbModel::link_of(const PairKey& key) {
  const auto found = links_.find(key);
  if (found != links_.end()) return found->second;
  return links_.emplace(key, Link(seed_, link_name(key))).first->second;
}

double UwbModel::pair_bias_m(int vehicle_a, int antenna_a, int vehicle_b, int antenna_b) const {
  const Link link(seed_, link_name(key_of(vehicle_a, antenna_a, vehicle_b, antenna_b)));
  return options_.pair_bias_m + options_.pair_bias_sd_m * link.pair_bias_sd;
}

AntennaPattern UwbModel::pattern(int vehicle, int antenna) const {
  Rng rng(seed_, fmt::format("uwb pattern {}.{}", vehicle, antenna));
  // The mean square of each of the four terms is half its coefficient's variance: together
  // angle_bias_m^2.
  const double sd = options_.angle_bias_m / std::sqrt(2.0);
  AntennaPattern p;
  p.c1 = sd * rng.normal();
  p.s1 = sd * rng.normal();
  p.c2 = sd * rng.normal();
  p.s2 = sd * rng.normal();
  return p;
}

double UwbModel::stamp_error_s(int vehicle, Time t) const {
  RALI_ASSERT(vehicle >= 0 && vehicle < static_cast<int>(clocks_.size()));
  const Clock& clock = clocks_[static_cast<std::size_t>(vehicle)];
  return clock.offset_s + (start_ ? clock.drift * seconds_between(*start_, t) : 0.0);
}

double UwbModel::systematic_bias_m(const Link& link, const RadioEnd& a, const RadioEnd& b,
                                   double distance_m) const {
  const double far =
      options_.far_bias_m * (1.0 - std::exp(-distance_m / options_.far_bias_scale_m));
  return options_.pair_bias_m + options_.pair_bias_sd_m * link.pair_bias_sd + far +
         pattern(a.vehicle, a.antenna).at(azimuth_of(a, b.position())) +
         pattern(b.vehicle, b.antenna).at(azimuth_of(b, a.position()));
}

double UwbModel::loss_db(const Obstruction& between) const {
  return between.walls * options_.wall_loss_db + between.thickness_m * options_.wall_loss_db_per_m +
         between.bodies * options_.body_loss_db;
}

namespace {

/// Fraction of the full effect an obstacle has on noise and bursts, 0..1: receivers detect a
/// slightly weaker first path as reliably as before.
double blocked_fraction(const UwbOptions& o, double loss_db) {
  const double width = std::max(0.1, o.blocked_full_db - o.blocked_from_db);
  return std::clamp((loss_db - o.blocked_from_db) / width, 0.0, 1.0);
}

}  // namespace

double UwbModel::excess_m(Link& link, Time t, const Obstruction& between) const {
  const UwbOptions& o = options_;
  const double blocked = blocked_fraction(o, loss_db(between));
  const double fraction = std::lerp(o.clear_burst_fraction, o.blocked_burst_fraction, blocked);
  const double mean = std::lerp(o.clear_burst_m, o.blocked_burst_m, blocked);
  const bool missed = link.missed.next(t, fraction, o.burst_time_s, link.burst);
  const double draw = exponential(link.excess);  // always drawn: keeps streams in step
  if (link.missed.began()) link.burst_excess = draw;
  return between.thickness_m * (o.wall_index - 1.0) + between.bodies * o.body_delay_m +
         (missed ? link.burst_excess * mean : 0.0);
}

double UwbModel::noise_m(Link& link, Time t, double distance_m, double blocked) {
  const UwbOptions& o = options_;
  const double sd = std::hypot(o.sigma_m, o.sigma_per_m * distance_m, blocked * o.blocked_sigma_m);
  const double white = sd * link.white.normal();
  const double slow = o.slow_sigma_m * link.slow_error.next(t, o.slow_time_s, link.slow);
  truth_.outlier = link.rare.uniform() < o.outlier_fraction;
  const double sign = link.rare.uniform() < 0.5 ? -1.0 : 1.0;
  const double gross = sign * o.outlier_m * exponential(link.rare);
  return white + slow + (truth_.outlier ? gross : 0.0);
}

UwbModel::Power UwbModel::power_of(Link& link, Time t, double distance_m, double loss_db,
                                   double echoes_db) const {
  const UwbOptions& o = options_;
  constexpr double kFadingTime_s = 2.0;
  const double fading = o.fading_db * link.fading.next(t, kFadingTime_s, link.fade);
  const double direct =
      o.power_1m_dbm - path_loss_db(distance_m, o.path_loss_exponent) - loss_db + fading;
  // Indirect paths make up for half of the loss; the first path has all of it.
  return {direct + 0.5 * loss_db + echoes_db, direct - o.first_path_gap_db};
}

std::optional<sensor::RangeSample> UwbModel::measure(Time t, const RadioEnd& a, const RadioEnd& b,
                                                     const RayCaster& world,
                                                     std::span<const RadioBody> bodies) {
  RALI_ASSERT(std::max(a.vehicle, b.vehicle) < static_cast<int>(clocks_.size()));
  const UwbOptions& o = options_;
  if (!start_) start_ = t;
  Link& link = link_of(key_of(a.vehicle, a.antenna, b.vehicle, b.antenna));
  const Vec3 at_a = a.position();
  const Vec3 at_b = b.position();
  const double distance = (at_b - at_a).norm();
  const Obstruction between = trace_line(world, at_a, at_b, o.wall_thickness_m, bodies);
  const Multipath echoes =
      multipath_between(world, at_a, at_b, {o.multipath_m, o.pulse_m, o.reflection});
  truth_ = {t, distance, !between.clear(), systematic_bias_m(link, a, b, distance)};
  truth_.excess_m = excess_m(link, t, between) + echoes.range_error_m;
  const double loss = loss_db(between);
  const double noise = noise_m(link, t, distance, blocked_fraction(o, loss));
  const Power power = power_of(link, t, distance, loss, echoes.power_db);
  const double reading = link.power.normal() * o.power_noise_db;
  const double first_reading = link.power.normal() * o.power_noise_db;
  const double jitter = link.stamp.normal() * o.stamp_jitter_s;
  const double lost = o.loss_fraction + (1.0 - o.loss_fraction) *
                                            loss_probability(power.total_dbm, o.sensitivity_dbm);
  if (link.rare.uniform() < lost || distance > o.max_range_m) return std::nullopt;

  double range = std::max(0.0, distance + truth_.bias_m + truth_.excess_m + noise);
  if (o.resolution_m > 0.0) range = std::round(range / o.resolution_m) * o.resolution_m;
  sensor::RangeSample sample;
  sample.t = t + Duration::from_s(stamp_error_s(a.vehicle, t) + jitter);
  sample.from = VehicleId{static_cast<std::uint16_t>(a.vehicle)};
  sample.to = VehicleId{static_cast<std::uint16_t>(b.vehicle)};
  sample.from_antenna = static_cast<std::uint8_t>(a.antenna);
  sample.to_antenna = static_cast<std::uint8_t>(b.antenna);
  sample.range_m = range;
  sample.rssi_dbm = reported_power_dbm(power.total_dbm, o.ceiling_dbm) + reading;
  sample.first_path_dbm =
      reported_power_dbm(power.first_path_dbm, o.ceiling_dbm - o.first_path_gap_db) + first_reading;
  return sample;
}

}  // namespace rali::sim
