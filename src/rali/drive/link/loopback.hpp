#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/base/result.hpp"
#include "rali/base/rng.hpp"
#include "rali/base/time.hpp"
#include "rali/drive/link/link_settings.hpp"
#include "rali/fleet/messages/kind.hpp"
#include "rali/wire/byte_writer.hpp"

namespace rali::drive {

/// A message that has arrived.
struct Delivery {
  Time t;  ///< of arrival
  VehicleId from, to;
  std::shared_ptr<const wire::Bytes> bytes;
};

/// The radio between vehicles of one process on a virtual clock: rate, delay, loss, duplication and
/// partitions of each ordered pair. Same seed and same calls give the same deliveries.
class Loopback {
 public:
  Loopback(std::vector<VehicleId> fleet, const LinkSettings& settings, std::uint64_t seed);

  /// Sets the link from one vehicle to another (one direction) apart from the others.
  void set_link(VehicleId from, VehicleId to, const LinkSettings& settings);

  /// Messages sent from `begin` until before `end` do not arrive; one direction.
  void cut(VehicleId from, VehicleId to, Time begin, Time end);
  /// Between this vehicle and all others, both ways.
  void cut_off(VehicleId vehicle, Time begin, Time end);

  /// From now on it neither sends nor receives; messages already sent still arrive.
  void kill(VehicleId vehicle);
  void revive(VehicleId vehicle);

  [[nodiscard]] bool alive(VehicleId vehicle) const;

  /// True if a message sent now would not be cut. For displays: vehicles cannot query it.
  [[nodiscard]] bool connected(VehicleId from, VehicleId to, Time now) const;

  /// @param to none: all others, each over its own link. Times must not go back.
  void send(Time now, VehicleId from, std::optional<VehicleId> to, wire::Bytes bytes);

  /// All messages that arrived until `now`, by time of arrival, then by the order of sending.
  [[nodiscard]] std::vector<Delivery> deliver(Time now);

  /// Sent messages: one row for each message and receiver, whether it arrives or not.
  [[nodiscard]] const fleet::TrafficCount& sent(VehicleId from, VehicleId to) const;
  /// Of all pairs.
  [[nodiscard]] fleet::TrafficCount sent() const;

  /// Messages sent by a vehicle: each once, for any number of receivers.
  [[nodiscard]] const fleet::TrafficCount& reported(VehicleId vehicle) const;

  /// Messages that arrived, with repetitions.
  [[nodiscard]] const fleet::TrafficCount& arrived() const { return arrived_; }

 private:
  struct Link {
    LinkSettings settings;
    Rng rng;
    Time free_at;  ///< when the last message will have left
    std::vector<std::pair<Time, Time>> cuts;
    fleet::TrafficCount sent;
  };

  using Pair = std::pair<VehicleId, VehicleId>;

  void send_over(Link& link, Time now, const Pair& pair,
                 const std::shared_ptr<const wire::Bytes>& bytes);
  [[nodiscard]] static bool is_cut(const Link& link, Time now);

  std::vector<VehicleId> fleet_;  ///< ascending
  std::map<Pair, Link> links_;
  std::map<VehicleId, bool> alive_;
  std::map<VehicleId, fleet::TrafficCount> reported_;
  /// By time of arrival and running number: at equal times in the order of sending.
  std::map<std::pair<Time, std::uint64_t>, Delivery> on_the_way_;
  std::uint64_t sent_ = 0;
  fleet::TrafficCount arrived_;
};

}  // namespace rali::drive
