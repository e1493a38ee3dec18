#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "rali/fleet/messages/messages.hpp"
#include "rali/wire/goal_status.hpp"

namespace rali::host {

/// What became of the goals that a vehicle was sent, as its navigation tells it. The navigation
/// gives each goal a name of its own, so the first name that was not there when an order went out
/// is that order's.
class GoalWatch {
 public:
  /// An order goes out now. The same number again changes nothing.
  void sent(std::uint64_t number);

  void heard(const wire::GoalStatusArray& status);

  /// How the drive to the last order goes; nothing: the navigation has not said anything of it.
  [[nodiscard]] std::optional<fleet::DriveState> state() const;

 private:
  using GoalId = std::array<std::uint8_t, 16>;

  std::optional<std::uint64_t> number_;
  std::optional<GoalId> before_;  ///< the newest goal when the order went out
  std::optional<wire::GoalStatus> newest_;
};

}  // namespace rali::host
