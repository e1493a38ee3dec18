#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/base/time.hpp"

namespace rali::net {

/// Priority of messages on a slow link (middleware 4.2): roles and statuses go before all facts.
enum class Urgency : std::uint8_t { kRole, kStatus, kBulk };

/// A message of another vehicle, authenticated and not a repetition.
struct Arrived {
  Time t;  ///< of arrival, by the clock of this machine (UTC)
  VehicleId from;
  std::vector<std::uint8_t> bytes;
};

struct SeenCounter;

/// Traffic counts with one other vehicle since the link was opened.
struct LinkCounts {
  VehicleId peer;
  std::uint64_t sent = 0, sent_bytes = 0;
  std::uint64_t refused = 0;  ///< by a full queue: the sender keeps it and retries
  std::uint64_t arrived = 0, arrived_bytes = 0;
  std::uint64_t forged = 0;      ///< not authenticated by the fleet's key
  std::uint64_t repeated = 0;    ///< authenticated, but received before or too old
  std::uint64_t overflowed = 0;  ///< authenticated, but not taken in time: the queue was full
  bool matched = false;          ///< discovery sees the vehicle's process now
};

/// Messages between the vehicles of a fleet. Neither send nor take blocks. All calls from one
/// thread.
class FleetLink {
 public:
  virtual ~FleetLink() = default;

  /// kRole and kStatus are sent once: the protocol repeats them. kBulk is retransmitted until the
  /// receiver has it or is gone; it may be lost only shortly after `matched`.
  /// @param to none: all others
  /// @return false: refused, because the queue to (one of) the receivers is full, or kBulk has no
  /// receiver, or it is too large. A retry to all may reach some twice.
  [[nodiscard]] virtual bool send(std::optional<VehicleId> to, Urgency urgency,
                                  std::span<const std::uint8_t> bytes) = 0;

  /// Messages since the last call, in the order of arrival.
  [[nodiscard]] virtual std::vector<Arrived> take() = 0;

  /// Waits until a message has arrived, at most `timeout`. @return whether one has
  virtual bool wait(Duration timeout) = 0;

  /// One row for each other vehicle.
  [[nodiscard]] virtual std::vector<LinkCounts> counts() const = 0;

  /// The newest accepted roles and statuses, to be saved to disk (seen_counters.hpp).
  [[nodiscard]] virtual std::vector<SeenCounter> seen() const;

  /// Dropped messages that do not claim to come from a vehicle of this fleet.
  [[nodiscard]] virtual std::uint64_t strangers() const { return 0; }
};

}  // namespace rali::net
