#include "rali/vehicle/back_end.hpp"

namespace rali::vehicle {

BackEnd::BackEnd(VehicleId self, const VehicleSettings& settings)
    : self_(self), settings_(settings) {}

void BackEnd::add(const std::optional<PathNode>& node, const std::vector<RangeRecord>& ranges) {
  if (!settings_.back_end.use) return;
  if (!nodes_.empty()) {
    for (const RangeRecord& r : ranges) ranges_.push_back({r, nodes_.size() - 1});
  }
  if (!node || !node->step.levelled) return;
  if (node->step.blind && !nodes_.empty()) {
    blind_m_ += (node->step.T_odom_body.p - nodes_.back().step.T_odom_body.p).norm();
  }
  nodes_.push_back(*node);
}

void BackEnd::forget() {
  nodes_.clear();
  ranges_.clear();
  blind_m_ = 0.0;
}

}  // namespace rali::vehicle
