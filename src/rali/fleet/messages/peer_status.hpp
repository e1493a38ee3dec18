#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/base/time.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/ranging/passage_walls.hpp"

namespace rali::fleet {

/// Where the speaker has an antenna of another vehicle that stands, by its own ranges to it.
struct SeenPeer {
  VehicleId vehicle;
  std::uint8_t antenna = 0;
  geometry::Vec3 apart_start_m = geometry::Vec3::Zero();  ///< from the speaker's body, in its start
  geometry::Mat3 covariance_m2 = geometry::Mat3::Zero();
};

/// Where a vehicle believes to be in the frame of its own start: level, at its first pose, heading
/// along x.
struct PeerPose {
  geometry::SE3 T_start_body;
  geometry::Mat3 position_covariance_m2 = geometry::Mat3::Zero();
  /// Beside its first antenna, where it stands in a passage.
  std::optional<ranging::PassageWalls> walls = std::nullopt;
  std::vector<SeenPeer> seen = {};  ///< while it stands
};

/// What another vehicle says about itself: only while one stands are ranges to it ranges to a
/// place.
struct PeerStatus {
  VehicleId vehicle;
  Time t;
  bool at_rest = false;
  /// Nothing before gravity is known, and where it is lost.
  std::optional<PeerPose> pose = std::nullopt;
};

}  // namespace rali::fleet
