#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "rali/fleet/messages/messages.hpp"
#include "rali/wire/goal_status.hpp"

namespace rali::host {

/// State of the goals sent to a vehicle, as reported by its navigation. The navigation assigns each
/// goal its own id, so the first id that was not there when an order was sent belongs to that
/// order.
class GoalWatch {
 public:
  /// An order is sent now. The same number again changes nothing.
  void sent(std::uint64_t number);

  void received(const wire::GoalStatusArray& status);

  /// State of the drive for the last order; empty: the navigation has not reported on it.
  [[nodiscard]] std::optional<fleet::DriveState> state() const;

 private:
  using GoalId = std::array<std::uint8_t, 16>;

  std::optional<std::uint64_t> number_;
  std::optional<GoalId> before_;  ///< the newest goal when the order was sent
  std::optional<wire::GoalStatus> newest_;
};

}  // namespace rali::host
