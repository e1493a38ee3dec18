#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/base/time.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/ranging/passage_walls.hpp"

namespace rali::fleet {

/// Position of a standing peer's antenna, estimated by the sender from its own ranges.
struct SeenPeer {
  VehicleId vehicle;
  std::uint8_t antenna = 0;
  geometry::Vec3 apart_start_m = geometry::Vec3::Zero();  ///< from the sender's body, in its start
                                                          ///< frame
  geometry::Mat3 covariance_m2 = geometry::Mat3::Zero();
};

/// Estimated pose of a vehicle in the frame of its own start: level, at its first pose, heading
/// along x.
struct PeerPose {
  geometry::SE3 T_start_body;
  geometry::Mat3 position_covariance_m2 = geometry::Mat3::Zero();
  /// At its first antenna, if it is in a passage at standstill.
  std::optional<ranging::PassageWalls> walls = std::nullopt;
  std::vector<SeenPeer> seen = {};  ///< while it is at standstill
};

/// State that another vehicle reports. Only while it is at standstill are ranges to it ranges to a
/// fixed landmark.
struct PeerStatus {
  VehicleId vehicle;
  Time t;
  bool at_rest = false;
  /// Nothing before gravity is known, and after it is lost.
  std::optional<PeerPose> pose = std::nullopt;
};

}  // namespace rali::fleet
