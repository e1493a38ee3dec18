#include <algorithm>

#include <fmt/format.h>

#include "rali/fleet/node/node.hpp"

namespace rali::fleet {

void Node::on(const OperatorOrder& event) {
  if (event.kind == OperatorOrder::Kind::kAssumeLost) {
    std::vector<VehicleId> fleet = role_.durable.fleet;
    if (event.vehicle == self_ || std::erase(fleet, event.vehicle) == 0) {
      return report("fleet.order_refused", Severity::kWarning,
                    "the operator's order names no other vehicle that has a vote");
    }
    return give(RoleFleet{std::move(fleet)});
  }
  if (role_.mode != RoleMode::kAnchor || !mapper_) {
    return report("fleet.order_refused", Severity::kWarning,
                  "only the anchor can end a round or the mission: give it the order");
  }
  if (event.kind == OperatorOrder::Kind::kEndRound) return give(RoleEndRound{});
  end_mission(RoundEnd::kOperator);
}

}  // namespace rali::fleet
