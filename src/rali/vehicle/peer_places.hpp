#pragma once

#include <map>
#include <optional>

#include "rali/vehicle/event.hpp"
#include "rali/vehicle/settings.hpp"

namespace rali::vehicle {

/// What is known of another vehicle.
struct PeerWatch {
  PeerSettings settings;
  Time t_status;
  bool heard = false;
  bool at_rest = false;
  bool left = false;                              ///< drives, and is not any more where it stood
  std::optional<geometry::Vec3> p_start_stood_m;  ///< by its own word, in its start
  bool moved = false;  ///< since the start: what was known of its place then is worth nothing
  std::optional<PeerPose> pose;  ///< as it said last

  /// Older statuses than the last are ignored.
  /// @param stay_m who says it drives has not left before it is so far away
  void on(const PeerStatus& status, double stay_m);

  [[nodiscard]] bool stands_at(Time t, double status_valid_s) const {
    return heard && at_rest && (t - t_status).s() < status_valid_s;
  }
};

/// All peers by their number.
[[nodiscard]] std::map<VehicleId, PeerWatch> watch_peers(const VehicleSettings& settings);

/// Where something is, and how well that is known.
struct KnownPlace {
  geometry::Vec3 p_odom_m = geometry::Vec3::Zero();
  geometry::Mat3 covariance_m2 = geometry::Mat3::Zero();
};

/// A vehicle that is heard and whose place is not known: only how far away it is.
struct HeardPeer {
  geometry::Vec3 p_body_antenna_m = geometry::Vec3::Zero();  ///< of the own antenna
  double range_m = 0.0;
};

/// Where a point of the peer's body is in odom: by the start poses measured by hand, and, once it
/// has moved, by what it says of its way since. Nothing where either is not known.
[[nodiscard]] std::optional<KnownPlace> place_of(const PeerWatch& peer,
                                                 const geometry::Vec3& p_peer_m,
                                                 const geometry::SE3& T_odom_first,
                                                 const geometry::Vec3& up_odom);

}  // namespace rali::vehicle
