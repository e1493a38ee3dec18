#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "rali/base/time.hpp"
#include "rali/fleet/facts/exchange_settings.hpp"
#include "rali/fleet/facts/fact_store.hpp"
#include "rali/fleet/facts/send_queue.hpp"
#include "rali/fleet/facts/want_list.hpp"
#include "rali/fleet/messages/messages.hpp"

namespace rali::fleet {

/// Distributes the facts of all vehicles to all vehicles over links that lose, repeat, delay and
/// break (algorithms_fleet 11.2, middleware 4.2). A new fact is sent once, unasked, to the vehicles
/// in reach. A receiver compares inventories and requests lost facts: from the author, else from
/// any holder. Time is an argument; the same calls give the same messages.
class Exchange {
 public:
  Exchange(VehicleId self, const std::vector<VehicleId>& fleet, const ExchangeSettings& settings);

  /// After a restart: message numbers continue beyond those of earlier epochs, which peers
  /// remember. Facts already in the store are not sent unasked again.
  void go_on(std::uint32_t epoch, const FactStore& store);

  /// Receives a message of any kind: facts go into the store, exchange messages are processed. All
  /// other kinds (role, status, table) only show that the link is up.
  void receive(const Envelope& envelope, FactStore& store, Time now);

  /// Messages to send now. Call it at each event, at least ten times a second.
  [[nodiscard]] std::vector<Envelope> step(const FactStore& store, Time now);

  /// During a round, points are sent to the anchor only (11.4); none: to all.
  void set_points_to(std::optional<VehicleId> anchor);

  /// Requests an inventory with the next step: at contact, at a seal, at the end of a round.
  void announce() { announce_ = true; }

  [[nodiscard]] bool in_reach(VehicleId peer, Time now) const;

  /// True if the peer's last inventory contains everything that `inventory` names.
  [[nodiscard]] bool peer_holds(VehicleId peer, const Inventory& inventory) const;

  /// Number of facts that are known to exist and are missing here.
  [[nodiscard]] std::size_t lacking() const { return wants_.size(); }

  /// Likewise, of one author.
  [[nodiscard]] std::size_t lacking_of(VehicleId author) const { return wants_.size_of(author); }

  /// Number of facts queued for a peer.
  [[nodiscard]] std::size_t waiting(VehicleId peer) const;

  void set_free_bytes(std::uint64_t bytes) { free_bytes_ = bytes; }

 private:
  struct Peer {
    explicit Peer(const ExchangeSettings& settings) : queue(settings) {}

    std::optional<Time> received;
    std::optional<std::uint32_t> inventory_number;
    Holdings holdings;
    SendQueue queue;
    std::deque<std::pair<std::uint32_t, Time>> requests_seen;  ///< a radio may repeat them
    std::map<StreamKey, SeqSet> withheld;  ///< points not sent to it, of which it is not informed
                                           ///< yet
  };

  void on_inventory(Peer& peer, const Inventory& inventory, Time now);
  void on_request(Peer& peer, const Request& request, const FactStore& store, Time now);
  void on_withheld(const Withheld& message, const FactStore& store);
  void push_new(const FactStore& store, Time now);
  void add_requests(const FactStore& store, Time now, std::vector<Envelope>& out);
  void add_facts(Time now, std::vector<Envelope>& out);
  [[nodiscard]] std::vector<Holder> holders(Time now) const;

  [[nodiscard]] bool takes_points(VehicleId vehicle) const {
    return !points_to_ || *points_to_ == vehicle;
  }

  VehicleId self_;
  ExchangeSettings settings_;
  std::map<VehicleId, Peer> peers_;
  WantList wants_;
  Holdings withheld_;  ///< points that peers withhold from this vehicle
  std::optional<VehicleId> points_to_;
  std::map<StreamKey, std::uint32_t> pushed_;  ///< of own streams: the next number to be sent
  std::optional<Time> last_inventory_;
  std::uint32_t inventories_ = 0, requests_ = 0;
  std::uint64_t free_bytes_ = 0;
  bool announce_ = false;
};

}  // namespace rali::fleet
