#pragma once

#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

#include "rali/ranging/exchange_pairer.hpp"
#include "rali/sim/fleet/fleet_simulation.hpp"

namespace rali::drive {

/// Puts what simulated sensors send in the order in which vehicles get it, as the loop over
/// recordings does: by data time, inertial samples before ranges before sweeps; a range when it has
/// met the other direction of its exchange, half a slot later.
class EventOrder {
 public:
  explicit EventOrder(const ranging::ExchangeSettings& exchange)
      : half_slot_(Duration::from_s(0.5 * exchange.slot_s)), pairer_(exchange) {}

  void add(const sim::FleetMessage& message);

  /// All that is due, given that nothing from before `now` will be added any more.
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
