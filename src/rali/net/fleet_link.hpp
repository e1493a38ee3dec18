#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/base/time.hpp"

namespace rali::net {

/// Which messages go first where a link is slow (middleware 4.2): roles and statuses pass all
/// facts.
enum class Urgency : std::uint8_t { kRole, kStatus, kBulk };

/// A message of another vehicle, authenticated and not seen before.
struct Arrived {
  Time t;  ///< of arrival, by the clock of this machine (UTC)
  VehicleId from;
  std::vector<std::uint8_t> bytes;
};

struct SeenCounter;

/// What happened on the way to and from one other vehicle since the link was opened.
struct LinkCounts {
  VehicleId peer;
  std::uint64_t sent = 0, sent_bytes = 0;
  std::uint64_t refused = 0;  ///< by a full queue: the sender keeps it and tries again
  std::uint64_t arrived = 0, arrived_bytes = 0;
  std::uint64_t forged = 0;      ///< not authenticated by the fleet's key
  std::uint64_t repeated = 0;    ///< authenticated, but seen before or too old
  std::uint64_t overflowed = 0;  ///< authenticated, but not taken in time: the queue was full
  bool matched = false;          ///< discovery sees the vehicle's process now
};

/// Bytes between the vehicles of a fleet. Neither send nor take waits. All calls from one thread.
class FleetLink {
 public:
  virtual ~FleetLink() = default;

  /// kRole and kStatus are sent once: the protocol repeats them. kBulk is sent again until the
  /// receiver has it or is gone; only in the first moment after `matched` it may be lost.
  /// @param to none: all others
  /// @return false: not taken, because the queue to (one of) the receivers is full, or nobody is
  /// there to receive kBulk, or it is too large. Sent again to all, it may reach some twice.
  [[nodiscard]] virtual bool send(std::optional<VehicleId> to, Urgency urgency,
                                  std::span<const std::uint8_t> bytes) = 0;

  /// What has arrived since the last call, in the order of arrival.
  [[nodiscard]] virtual std::vector<Arrived> take() = 0;

  /// Waits until something has arrived, at most `timeout`. @return whether something has
  virtual bool wait(Duration timeout) = 0;

  /// One row for each other vehicle.
  [[nodiscard]] virtual std::vector<LinkCounts> counts() const = 0;

  /// The newest roles and statuses that were accepted, for the disk (seen_counters.hpp).
  [[nodiscard]] virtual std::vector<SeenCounter> seen() const;

  /// Dropped ones that do not even claim to be of a vehicle of this fleet.
  [[nodiscard]] virtual std::uint64_t strangers() const { return 0; }
};

}  // namespace rali::net
