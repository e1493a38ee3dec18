#pragma once

#include <map>

#include "rali/vehicle/event.hpp"
#include "rali/vehicle/settings.hpp"

namespace rali::vehicle {

/// What is known of another vehicle.
struct PeerWatch {
  PeerSettings settings;
  Time t_status;
  bool heard = false;
  bool at_rest = false;
  bool moved = false;  ///< since the start: what was known of its place then is worth nothing

  /// Older statuses than the last are ignored.
  void on(const PeerStatus& status);

  [[nodiscard]] bool stands_at(Time t, double status_valid_s) const {
    return heard && at_rest && (t - t_status).s() < status_valid_s;
  }
};

/// All peers by their number.
[[nodiscard]] std::map<VehicleId, PeerWatch> watch_peers(const VehicleSettings& settings);

/// Where a point of the peer's body is in odom, as measured by hand before the start.
[[nodiscard]] geometry::Vec3 place_of(const PeerPrior& prior, const geometry::Vec3& p_peer_m,
                                      const geometry::SE3& T_odom_first,
                                      const geometry::Vec3& up_odom);

}  // namespace rali::vehicle
