#pragma once

#include <map>
#include <optional>

#include "rali/vehicle/event.hpp"
#include "rali/vehicle/settings.hpp"

namespace rali::vehicle {

/// State of another vehicle, from the settings and its reports.
struct PeerWatch {
  PeerSettings settings;
  Time t_status;
  bool received = false;
  bool at_rest = false;
  bool left = false;  ///< in motion, and away from its last position at standstill
  /// Has left a position at standstill, or may have: then its ranges from there say nothing about
  /// where it is now. For the user to clear.
  bool gone = false;
  std::optional<geometry::Vec3> p_start_stood_m;  ///< reported, at last standstill
  bool moved = false;  ///< has left its start: the start pose alone no longer gives its position
  std::optional<PeerPose> pose;  ///< as last reported

  /// Ignores a status older than the last one.
  /// @param stay_m a peer that reports motion has not left before it is this far away
  /// @param silent_s without a status for this long, motion may have been missed
  void on(const PeerStatus& status, double stay_m, double silent_s);

  [[nodiscard]] bool stands_at(Time t, double status_valid_s) const {
    return received && at_rest && (t - t_status).s() < status_valid_s;
  }
};

/// All configured peers by id.
[[nodiscard]] std::map<VehicleId, PeerWatch> watch_peers(const VehicleSettings& settings);

/// Position of a landmark, and its covariance.
struct KnownLandmark {
  geometry::Vec3 p_odom_m = geometry::Vec3::Zero();
  geometry::Mat3 covariance_m2 = geometry::Mat3::Zero();
};

/// A peer with a received range but no known position.
struct ReceivedPeer {
  geometry::Vec3 p_body_antenna_m = geometry::Vec3::Zero();  ///< of the own antenna
  double range_m = 0.0;
};

/// Position in odom of a point of the peer's body: from the start poses measured by hand and, once
/// it has moved, from the pose it reports. Empty if either is not known.
[[nodiscard]] std::optional<KnownLandmark> place_of(const PeerWatch& peer,
                                                    const geometry::Vec3& p_peer_m,
                                                    const geometry::SE3& T_odom_first,
                                                    const geometry::Vec3& up_odom);

/// Sigma of the height at a distance: no odom is level to better than an accelerometer's bias, here
/// 0.2 m/s^2.
[[nodiscard]] inline double level_error_m(double distance_m) { return 0.02 * distance_m; }

}  // namespace rali::vehicle
