#include "rali/net/memory_fleet_link.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <set>
#include <utility>

namespace rali::net {

struct MemoryFleet::Hub {
  struct Waiting {
    Urgency urgency = Urgency::kRole;
    Arrived arrived;
  };

  using Path = std::pair<VehicleId, VehicleId>;  ///< from, to

  std::vector<VehicleId> vehicles;
  std::function<Time()> now;
  std::size_t queue_max = 0;

  mutable std::mutex mutex;
  std::condition_variable changed;
  std::set<Path> cuts;
  std::set<VehicleId> open;  ///< vehicles whose link exists
  std::map<VehicleId, std::deque<Waiting>> queues;
  std::map<Path, LinkCounts> counts;  ///< of the first vehicle, about the second

  /// Requires the lock. False: the queue is full or there is no receiver.
  bool put(VehicleId from, VehicleId to, Urgency urgency, std::span<const std::uint8_t> bytes);
  bool make_room(VehicleId to, VehicleId from, Urgency urgency);
};

bool MemoryFleet::Hub::make_room(VehicleId to, VehicleId from, Urgency urgency) {
  std::deque<Waiting>& queue = queues[to];
  const auto same = [&](const Waiting& w) {
    return w.arrived.from == from && (w.urgency == Urgency::kBulk) == (urgency == Urgency::kBulk);
  };
  const auto n = static_cast<std::size_t>(std::count_if(queue.begin(), queue.end(), same));
  if (n < queue_max) return true;
  if (urgency == Urgency::kBulk) return false;
  queue.erase(std::find_if(queue.begin(), queue.end(), same));
  ++counts[{to, from}].overflowed;
  return true;
}

bool MemoryFleet::Hub::put(VehicleId from, VehicleId to, Urgency urgency,
                           std::span<const std::uint8_t> bytes) {
  LinkCounts& sender = counts[{from, to}];
  const bool there = open.count(to) > 0 && cuts.count({from, to}) == 0;
  if ((!there && urgency == Urgency::kBulk) || (there && !make_room(to, from, urgency))) {
    ++sender.refused;
    return false;
  }
  ++sender.sent;
  sender.sent_bytes += bytes.size();
  if (!there) return true;  // lost silently, as over the air
  LinkCounts& receiver = counts[{to, from}];
  ++receiver.arrived;
  receiver.arrived_bytes += bytes.size();
  queues[to].push_back({urgency, {now(), from, {bytes.begin(), bytes.end()}}});
  changed.notify_all();
  return true;
}

namespace {

class MemoryFleetLink final : public FleetLink {
 public:
  MemoryFleetLink(std::shared_ptr<MemoryFleet::Hub> hub, VehicleId self)
      : hub_(std::move(hub)), self_(self) {
    const std::lock_guard lock(hub_->mutex);
    hub_->open.insert(self_);
  }

  ~MemoryFleetLink() override {
    const std::lock_guard lock(hub_->mutex);
    hub_->open.erase(self_);
    hub_->queues.erase(self_);
  }

  MemoryFleetLink(const MemoryFleetLink&) = delete;
  MemoryFleetLink& operator=(const MemoryFleetLink&) = delete;

  [[nodiscard]] bool send(std::optional<VehicleId> to, Urgency urgency,
                          std::span<const std::uint8_t> bytes) override {
    const std::lock_guard lock(hub_->mutex);
    bool taken = true, known = !to;
    for (const VehicleId peer : hub_->vehicles) {
      if (peer == self_ || (to && *to != peer)) continue;
      known = true;
      if (!to && urgency == Urgency::kBulk && !is_there(peer)) continue;
      taken = hub_->put(self_, peer, urgency, bytes) && taken;
    }
    return taken && known;
  }

  [[nodiscard]] std::vector<Arrived> take() override {
    const std::lock_guard lock(hub_->mutex);
    std::vector<Arrived> out;
    for (MemoryFleet::Hub::Waiting& waiting : hub_->queues[self_]) {
      out.push_back(std::move(waiting.arrived));
    }
    hub_->queues[self_].clear();
    return out;
  }

  bool wait(Duration timeout) override {
    std::unique_lock lock(hub_->mutex);
    return hub_->changed.wait_for(lock, std::chrono::nanoseconds(timeout.ns),
                                  [&] { return !hub_->queues[self_].empty(); });
  }

  [[nodiscard]] std::vector<LinkCounts> counts() const override {
    const std::lock_guard lock(hub_->mutex);
    std::vector<LinkCounts> out;
    for (const VehicleId peer : hub_->vehicles) {
      if (peer == self_) continue;
      LinkCounts row = hub_->counts[{self_, peer}];
      row.peer = peer;
      row.matched = is_there(peer);
      out.push_back(row);
    }
    return out;
  }

 private:
  [[nodiscard]] bool is_there(VehicleId peer) const {
    return hub_->open.count(peer) > 0 && hub_->cuts.count({self_, peer}) == 0;
  }

  std::shared_ptr<MemoryFleet::Hub> hub_;
  VehicleId self_;
};

}  // namespace

MemoryFleet::MemoryFleet(std::vector<VehicleId> vehicles, std::function<Time()> now,
                         std::size_t queue_max)
    : hub_(std::make_shared<Hub>()) {
  hub_->vehicles = std::move(vehicles);
  hub_->now = std::move(now);
  hub_->queue_max = queue_max;
}

MemoryFleet::~MemoryFleet() = default;

std::unique_ptr<FleetLink> MemoryFleet::link(VehicleId self) {
  return std::make_unique<MemoryFleetLink>(hub_, self);
}

void MemoryFleet::cut(VehicleId from, VehicleId to, bool is_cut) {
  const std::lock_guard lock(hub_->mutex);
  if (is_cut) {
    hub_->cuts.insert({from, to});
  } else {
    hub_->cuts.erase({from, to});
  }
}

}  // namespace rali::net
