#pragma once

#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

#include "rali/ranging/exchange_pairer.hpp"
#include "rali/sim/fleet/fleet_simulation.hpp"

namespace rali::drive {

/// Puts the messages of simulated sensors into the order in which the loop over recordings delivers
/// them: by data time, then inertial samples, ranges, scans. A range is due half a slot later, when
/// it has been paired with the opposite direction of its exchange.
class EventOrder {
 public:
  explicit EventOrder(const ranging::ExchangeSettings& exchange)
      : half_slot_(Duration::from_s(0.5 * exchange.slot_s)), pairer_(exchange) {}

  void add(const sim::FleetMessage& message);

  /// All messages that are due. The caller adds none from before `now` any more.
  [[nodiscard]] std::vector<sim::FleetMessage> take(Time now);

 private:
  using Key = std::tuple<Time, int, int, std::uint64_t>;  ///< time, rank, vehicle, order

  void put(Time t, int rank, sim::FleetMessage message);
  void settle();

  Duration half_slot_;
  ranging::ExchangePairer pairer_;
  std::vector<ranging::PairedRange> paired_;
  std::map<Key, sim::FleetMessage> due_;
  std::uint64_t order_ = 0;
};

}  // namespace rali::drive
