#include "rali/drive/link/loopback.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "rali/wire/fleet/codec.hpp"

namespace rali::drive {

Loopback::Loopback(std::vector<VehicleId> fleet, const LinkSettings& settings, std::uint64_t seed)
    : fleet_(std::move(fleet)) {
  std::sort(fleet_.begin(), fleet_.end());
  for (const VehicleId from : fleet_) {
    alive_[from] = true;
    for (const VehicleId to : fleet_) {
      if (from == to) continue;
      // A random stream for each link: messages on one do not change the outcome on another.
      const std::string name = fmt::format("link.{}.{}", from.value, to.value);
      links_.emplace(Pair{from, to}, Link{settings, Rng(seed, name), Time::from_ns(0), {}, {}});
    }
  }
}

void Loopback::set_link(VehicleId from, VehicleId to, const LinkSettings& settings) {
  links_.at({from, to}).settings = settings;
}

void Loopback::cut(VehicleId from, VehicleId to, Time begin, Time end) {
  links_.at({from, to}).cuts.emplace_back(begin, end);
}

void Loopback::cut_off(VehicleId vehicle, Time begin, Time end) {
  for (const VehicleId other : fleet_) {
    if (other == vehicle) continue;
    cut(vehicle, other, begin, end);
    cut(other, vehicle, begin, end);
  }
}

void Loopback::kill(VehicleId vehicle) { alive_.at(vehicle) = false; }

void Loopback::revive(VehicleId vehicle) { alive_.at(vehicle) = true; }

bool Loopback::alive(VehicleId vehicle) const { return alive_.at(vehicle); }

bool Loopback::is_cut(const Link& link, Time now) {
  return std::any_of(link.cuts.begin(), link.cuts.end(),
                     [now](const auto& c) { return c.first <= now && now < c.second; });
}

bool Loopback::connected(VehicleId from, VehicleId to, Time now) const {
  return alive(from) && alive(to) && !is_cut(links_.at({from, to}), now);
}

void Loopback::send(Time now, VehicleId from, std::optional<VehicleId> to, wire::Bytes bytes) {
  if (!alive(from)) return;
  const auto shared = std::make_shared<const wire::Bytes>(std::move(bytes));
  reported_[from].add(wire::envelope_kind(*shared), shared->size());
  for (const VehicleId other : fleet_) {
    if (other == from || (to && *to != other)) continue;
    const Pair pair{from, other};
    send_over(links_.at(pair), now, pair, shared);
  }
}

void Loopback::send_over(Link& link, Time now, const Pair& pair,
                         const std::shared_ptr<const wire::Bytes>& bytes) {
  const LinkSettings& s = link.settings;
  const auto size = static_cast<double>(bytes->size());
  link.sent.add(wire::envelope_kind(*bytes), bytes->size());
  Time leaves = now;
  if (s.rate_Bps > 0.0) {
    const Time begins = std::max(now, link.free_at);
    if ((begins - now).s() * s.rate_Bps + size > s.queue_bytes) return;
    leaves = begins + Duration::from_s(size / s.rate_Bps);
    link.free_at = leaves;
  }
  // All numbers are drawn whatever happens to the message: a cut then changes nothing after it.
  const bool lost = link.rng.uniform() < s.loss;
  const int copies = link.rng.uniform() < s.duplication ? 2 : 1;
  const bool held_back = link.rng.uniform() < s.reordering;
  for (int k = 0; k < copies; ++k) {
    const double late_s =
        s.delay_s + s.jitter_s * link.rng.uniform() + (held_back ? s.reorder_s : 0.0);
    if (lost || is_cut(link, now)) continue;
    const Time due = leaves + Duration::from_s(late_s);
    on_the_way_.emplace(std::pair{due, sent_++}, Delivery{due, pair.first, pair.second, bytes});
  }
}

std::vector<Delivery> Loopback::deliver(Time now) {
  std::vector<Delivery> arrived;
  while (!on_the_way_.empty() && on_the_way_.begin()->first.first <= now) {
    Delivery delivery = std::move(on_the_way_.begin()->second);
    on_the_way_.erase(on_the_way_.begin());
    if (!alive(delivery.to)) continue;
    arrived_.add(wire::envelope_kind(*delivery.bytes), delivery.bytes->size());
    arrived.push_back(std::move(delivery));
  }
  return arrived;
}

const fleet::TrafficCount& Loopback::reported(VehicleId vehicle) const {
  static const fleet::TrafficCount kNothing;
  const auto found = reported_.find(vehicle);
  return found == reported_.end() ? kNothing : found->second;
}

const fleet::TrafficCount& Loopback::sent(VehicleId from, VehicleId to) const {
  return links_.at({from, to}).sent;
}

fleet::TrafficCount Loopback::sent() const {
  fleet::TrafficCount sum;
  for (const auto& [pair, link] : links_) sum.add(link.sent);
  return sum;
}

}  // namespace rali::drive
