#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "rali/fleet/centre/estimate.hpp"
#include "rali/fleet/messages/separator_prior.hpp"

namespace rali::fleet {

/// Poses of the paths of the largest group in its map: from an estimate, continued by each
/// vehicle's odometry. Immutable once published, so that steps and jobs may share it.
struct Placement {
  FleetEstimate estimate;
  /// Of the streams that are placed, at their newest keyframe in the estimate.
  std::map<StreamKey, geometry::SE3> T_map_odom;

  [[nodiscard]] bool holds(const StreamKey& stream) const { return T_map_odom.contains(stream); }

  /// The body at a node of a stream that is placed.
  /// @param keyframe the node's, if it has one  @param T_odom_body in its odometry
  [[nodiscard]] geometry::SE3 T_map_body(const StreamKey& stream,
                                         std::optional<std::uint32_t> keyframe,
                                         const geometry::SE3& T_odom_body) const {
    if (keyframe) {
      const auto known = estimate.keyframes.find({stream.vehicle, *keyframe});
      if (known != estimate.keyframes.end()) return known->second.T_map_body;
    }
    return T_map_odom.at(stream) * T_odom_body;
  }
};

}  // namespace rali::fleet
