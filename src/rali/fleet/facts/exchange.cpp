#include "rali/fleet/facts/exchange.hpp"

#include <algorithm>
#include <utility>

#include "rali/fleet/messages/kind.hpp"

namespace rali::fleet {

namespace {

/// The step back in the number distinguishes reordered inventories from a restart.
constexpr std::uint32_t kOvertakenMax = 64;
constexpr std::size_t kRequestsRemembered = 64;
/// Facts processed per request.
constexpr std::size_t kAnswersMax = 4096;

bool is_points(const Fact& fact) { return std::holds_alternative<KeyframePoints>(fact.body); }

/// The numbers of a set as intervals.
std::vector<SeqInterval> intervals_of(const SeqSet& set) {
  std::vector<SeqInterval> out;
  std::uint64_t next = 0;
  for (const SeqInterval& gap : set.gaps()) {
    if (gap.first > next) out.push_back({static_cast<std::uint32_t>(next), gap.first - 1});
    next = std::uint64_t{gap.last} + 1;
  }
  if (set.end() > next) {
    out.push_back({static_cast<std::uint32_t>(next), static_cast<std::uint32_t>(set.end() - 1)});
  }
  return out;
}

}  // namespace

Exchange::Exchange(VehicleId self, const std::vector<VehicleId>& fleet,
                   const ExchangeSettings& settings)
    : self_(self), settings_(settings), wants_(settings) {
  for (const VehicleId vehicle : fleet) {
    if (vehicle != self) peers_.emplace(vehicle, Peer(settings));
  }
}

void Exchange::go_on(std::uint32_t epoch, const FactStore& store) {
  // More messages than any single program run sends.
  constexpr std::uint32_t kNumbersPerEpoch = 1U << 20;
  inventories_ = requests_ = epoch * kNumbersPerEpoch;
  for (const StreamInventory& stream : store.streams()) {
    if (stream.stream.vehicle == self_) pushed_[stream.stream] = stream.end;
  }
}

void Exchange::set_points_to(std::optional<VehicleId> anchor) {
  if (points_to_ == anchor) return;
  points_to_ = anchor;
  if (takes_points(self_)) withheld_.clear();
  announce_ = true;
}

bool Exchange::in_reach(VehicleId peer, Time now) const {
  const auto found = peers_.find(peer);
  if (found == peers_.end() || !found->second.received) return false;
  return (now - *found->second.received).s() <= settings_.received_s;
}

std::size_t Exchange::waiting(VehicleId peer) const {
  const auto found = peers_.find(peer);
  return found == peers_.end() ? 0 : found->second.queue.size();
}

bool Exchange::peer_holds(VehicleId peer, const Inventory& inventory) const {
  const auto found = peers_.find(peer);
  if (found == peers_.end()) return false;
  static const SeqSet kNothing;
  for (const StreamInventory& stream : inventory.streams) {
    const auto held = found->second.holdings.find(stream.stream);
    const SeqSet& theirs = held == found->second.holdings.end() ? kNothing : held->second;
    if (theirs.first_lacking(SeqSet::from(stream), 0)) return false;
  }
  return true;
}

void Exchange::receive(const Envelope& envelope, FactStore& store, Time now) {
  const auto found = peers_.find(envelope.from);
  if (found == peers_.end() || (envelope.to && *envelope.to != self_)) return;
  Peer& peer = found->second;
  // On contact both sides send their inventory at once.
  if (!in_reach(envelope.from, now)) announce_ = true;
  peer.received = now;
  if (const auto* reported = std::get_if<FactMessage>(&envelope.message)) {
    store.add(reported->fact);
    wants_.came(*reported->fact, envelope.from, now);
  } else if (const auto* inventory = std::get_if<Inventory>(&envelope.message)) {
    on_inventory(peer, *inventory, now);
  } else if (const auto* request = std::get_if<Request>(&envelope.message)) {
    on_request(peer, *request, store, now);
  } else if (const auto* withheld = std::get_if<Withheld>(&envelope.message)) {
    on_withheld(*withheld, store);
  }
}

void Exchange::on_inventory(Peer& peer, const Inventory& inventory, Time now) {
  if (peer.inventory_number) {
    const std::uint32_t last = *peer.inventory_number;
    if (inventory.number <= last && last - inventory.number < kOvertakenMax) return;
  }
  peer.inventory_number = inventory.number;
  peer.holdings.clear();
  for (const StreamInventory& stream : inventory.streams) {
    if (stream.stream.vehicle != self_ && peers_.count(stream.stream.vehicle) == 0) continue;
    peer.holdings[stream.stream] = SeqSet::from(stream);
  }
  peer.queue.confirm(peer.holdings, now);
}

void Exchange::on_request(Peer& peer, const Request& request, const FactStore& store, Time now) {
  for (const auto& [number, t] : peer.requests_seen) {
    if (number == request.number && (now - t).s() < settings_.patience_max_s) return;
  }
  peer.requests_seen.emplace_back(request.number, now);
  if (peer.requests_seen.size() > kRequestsRemembered) peer.requests_seen.pop_front();
  peer.queue.grant(std::min(static_cast<double>(request.window_bytes), settings_.window_bytes));
  std::size_t looked_at = 0;
  for (const Want& want : request.wants) {
    store.for_each(want.stream, want.numbers.first, want.numbers.last, [&](const FactPtr& fact) {
      if (++looked_at > kAnswersMax) return false;
      if (request.without_points && is_points(*fact)) {
        peer.withheld[want.stream].insert(fact->key.seq);
      } else if (!peer.queue.just_sent(fact->key, now, settings_.patience_min_s)) {
        peer.queue.add(fact, true);
      }
      return true;
    });
  }
}

void Exchange::on_withheld(const Withheld& message, const FactStore& store) {
  if (takes_points(self_) || peers_.count(message.stream.vehicle) == 0) return;
  // Bounded like the store: numbers beyond the limits only cause requests without an answer.
  constexpr StoreLimits kLimits;
  if (withheld_.count(message.stream) == 0 && withheld_.size() >= kLimits.streams) return;
  std::size_t looked_at = 0;
  SeqSet& numbers = withheld_[message.stream];
  for (const SeqInterval& interval : message.numbers) {
    for (std::uint64_t seq = interval.first; seq <= interval.last; ++seq) {
      if (++looked_at > kAnswersMax || numbers.gap_count() >= kLimits.gaps) return;
      const FactKey key{message.stream.vehicle, message.stream.epoch,
                        static_cast<std::uint32_t>(seq)};
      if (store.find(key) == nullptr) numbers.insert(key.seq);
      wants_.drop(key);
    }
  }
}

void Exchange::push_new(const FactStore& store, Time now) {
  for (const StreamInventory& own : store.streams()) {
    if (own.stream.vehicle != self_) continue;
    std::uint32_t& next = pushed_[own.stream];
    store.for_each(own.stream, next, own.end - 1, [&](const FactPtr& fact) {
      for (auto& [vehicle, peer] : peers_) {
        if (!in_reach(vehicle, now)) continue;
        if (is_points(*fact) && !takes_points(vehicle)) {
          peer.withheld[own.stream].insert(fact->key.seq);
        } else {
          peer.queue.add(fact, false);
        }
      }
      return true;
    });
    next = own.end;
  }
}

std::vector<Holder> Exchange::holders(Time now) const {
  std::vector<Holder> out;
  for (const auto& [vehicle, peer] : peers_) {
    if (in_reach(vehicle, now)) out.push_back({vehicle, &peer.holdings});
  }
  return out;
}

void Exchange::add_requests(const FactStore& store, Time now, std::vector<Envelope>& out) {
  const std::vector<Holder> in_reach = holders(now);
  wants_.refresh(store, in_reach, withheld_, now);
  for (auto& [vehicle, wants] : wants_.ask(store, in_reach, now)) {
    out.push_back({self_, vehicle,
                   Request{++requests_, static_cast<std::uint32_t>(settings_.window_bytes),
                           !takes_points(self_), std::move(wants)}});
  }
}

void Exchange::add_facts(Time now, std::vector<Envelope>& out) {
  for (auto& [vehicle, peer] : peers_) {
    if (!in_reach(vehicle, now)) {
      peer.queue.clear();
      peer.withheld.clear();
      continue;
    }
    for (const FactPtr& fact : peer.queue.take(now)) {
      out.push_back({self_, vehicle, FactMessage{fact}});
    }
    for (const auto& [stream, numbers] : std::exchange(peer.withheld, {})) {
      out.push_back({self_, vehicle, Withheld{stream, intervals_of(numbers)}});
    }
  }
}

std::vector<Envelope> Exchange::step(const FactStore& store, Time now) {
  std::vector<Envelope> out;
  push_new(store, now);
  const double since_s = last_inventory_ ? (now - *last_inventory_).s() : settings_.inventory_s;
  const bool due = since_s >= (announce_ ? settings_.request_s : settings_.inventory_s);
  if (due) {
    out.push_back({self_, std::nullopt, store.inventory(++inventories_, free_bytes_)});
    last_inventory_ = now;
    announce_ = false;
  }
  add_requests(store, now, out);
  add_facts(now, out);
  return out;
}

}  // namespace rali::fleet
