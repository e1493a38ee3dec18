#include "rali/sim/radio/radio_model.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace rali::sim {

RadioOptions RadioOptions::ideal() {
  RadioOptions o;
  o.fading_db = o.power_noise_db = o.loss_fraction = 0.0;
  o.sensitivity_dbm = -200.0;
  o.delay_s = o.delay_jitter_s = 0.0;
  return o;
}

RadioModel::Link::Link(std::uint64_t seed, const std::string& name)
    : fade(seed, name + " fade"),
      noise(seed, name + " noise"),
      loss(seed, name + " loss"),
      delay(seed, name + " delay") {}

RadioModel::Link& RadioModel::link_of(int a, int b) {
  const std::pair<int, int> key{std::min(a, b), std::max(a, b)};
  const auto found = links_.find(key);
  if (found != links_.end()) return found->second;
  const std::string name = fmt::format("radio {}-{}", key.first, key.second);
  return links_.emplace(key, Link(seed_, name)).first->second;
}

double RadioModel::mean_power_dbm(const RadioEnd& a, const RadioEnd& b, const RayCaster& world,
                                  std::span<const RadioBody> bodies) const {
  const RadioOptions& o = options_;
  const geometry::Vec3 at_a = a.position();
  const geometry::Vec3 at_b = b.position();
  const Obstruction between = trace_line(world, at_a, at_b, o.wall_thickness_m, bodies);
  const double walls = std::min(o.max_wall_loss_db, between.walls * o.wall_loss_db +
                                                        between.thickness_m * o.wall_loss_db_per_m);
  return o.power_1m_dbm - path_loss_db((at_b - at_a).norm(), o.path_loss_exponent) - walls -
         between.bodies * o.body_loss_db;
}

double RadioModel::power_dbm(Link& link, Time t, const RadioEnd& a, const RadioEnd& b,
                             const RayCaster& world, std::span<const RadioBody> bodies) {
  if (!link.last || *link.last < t) {
    link.fading_sd = link.fading.next(t, options_.fading_time_s, link.fade);
    link.last = t;
  }
  return mean_power_dbm(a, b, world, bodies) + options_.fading_db * link.fading_sd;
}

std::optional<sensor::RadioSample> RadioModel::measure(Time t, const RadioEnd& a, const RadioEnd& b,
                                                       const RayCaster& world,
                                                       std::span<const RadioBody> bodies) {
  Link& link = link_of(a.vehicle, b.vehicle);
  const double power = power_dbm(link, t, a, b, world, bodies);
  const double reading = power + options_.power_noise_db * link.noise.normal();
  if (link.noise.uniform() < loss_probability(power, options_.sensitivity_dbm)) return std::nullopt;
  sensor::RadioSample sample;
  sample.t = t;
  sample.from = VehicleId{static_cast<std::uint16_t>(a.vehicle)};
  sample.to = VehicleId{static_cast<std::uint16_t>(b.vehicle)};
  sample.rssi_dbm = reading;
  return sample;
}

std::optional<Time> RadioModel::send(Time t, std::size_t bytes, const RadioEnd& a,
                                     const RadioEnd& b, const RayCaster& world,
                                     std::span<const RadioBody> bodies) {
  const RadioOptions& o = options_;
  Link& link = link_of(a.vehicle, b.vehicle);
  const double power = power_dbm(link, t, a, b, world, bodies);
  const double chance =
      o.loss_fraction + (1.0 - o.loss_fraction) * loss_probability(power, o.sensitivity_dbm);
  const bool lost = link.loss.uniform() < chance;
  const double jitter = -std::log(1.0 - link.delay.uniform()) * o.delay_jitter_s;
  Time& free = link.free[a.vehicle];
  const Time begin = std::max(free, t);
  if (seconds_between(t, begin) > o.max_queue_s) return std::nullopt;
  // A lost packet occupies the channel as well.
  free = begin + Duration::from_s(8.0 * static_cast<double>(bytes) / o.data_rate_bps);
  if (lost) return std::nullopt;
  return free + Duration::from_s(o.delay_s + jitter);
}

}  // namespace rali::sim
