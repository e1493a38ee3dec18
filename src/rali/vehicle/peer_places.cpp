#include "rali/vehicle/peer_places.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "rali/fleet/path/level.hpp"

namespace rali::vehicle {

using geometry::SE3;
using geometry::Vec3;

namespace {

/// Positive semidefinite but for rounding: with any other matrix a filter would diverge.
bool is_covariance(const geometry::Mat3& P) {
  if (!P.allFinite()) return false;
  constexpr double kHair = 1e-6;
  const geometry::Mat3 lifted = P + kHair * P.trace() * geometry::Mat3::Identity();
  return P.isZero(0.0) || lifted.llt().info() == Eigen::Success;
}

/// One invalid number would spoil whatever is estimated with it.
bool whole(const PeerPose& pose) {
  const bool walls = !pose.walls || (pose.walls->axis.allFinite() && pose.walls->left_m > 0.0 &&
                                     pose.walls->right_m > 0.0 &&
                                     std::isfinite(pose.walls->left_m + pose.walls->right_m));
  const bool seen = std::all_of(pose.seen.begin(), pose.seen.end(), [](const SeenPeer& peer) {
    return peer.apart_start_m.allFinite() && is_covariance(peer.covariance_m2);
  });
  return walls && seen && pose.T_start_body.p.allFinite() && pose.T_start_body.R.allFinite() &&
         is_covariance(pose.position_covariance_m2);
}

}  // namespace

void PeerWatch::on(const PeerStatus& status, double stay_m, double silent_s) {
  if (received && status.t < t_status) return;
  const bool stood = at_rest || p_start_stood_m;
  const bool silent = received && seconds_between(t_status, status.t) > silent_s;
  received = true;
  t_status = status.t;
  at_rest = status.at_rest;
  pose = status.pose && whole(*status.pose) ? status.pose : std::nullopt;
  const std::optional<Vec3> p_m = pose ? std::optional<Vec3>(pose->T_start_body.p) : std::nullopt;
  const auto near_m = [&](const Vec3& stood_m) { return (*p_m - stood_m).norm() < stay_m; };
  const bool elsewhere = silent && p_m && p_start_stood_m && !near_m(*p_start_stood_m);
  if (at_rest) p_start_stood_m = p_m;
  const bool there = p_m && p_start_stood_m && near_m(*p_start_stood_m);
  left = !at_rest && !there;
  gone = gone || left || elsewhere;
  moved = moved || (stood && (left || elsewhere));
}

std::map<VehicleId, PeerWatch> watch_peers(const VehicleSettings& settings) {
  std::map<VehicleId, PeerWatch> peers;
  for (const PeerSettings& peer : settings.peers) {
    PeerWatch watch;
    watch.settings = peer;
    peers.emplace(peer.id, std::move(watch));
  }
  return peers;
}

std::optional<KnownLandmark> place_of(const PeerWatch& peer, const Vec3& p_peer_m,
                                      const SE3& T_odom_first, const Vec3& up_odom) {
  if (!peer.settings.prior || (peer.moved && !peer.pose)) return std::nullopt;
  const PeerPrior& prior = *peer.settings.prior;
  const SE3 T_odom_start = fleet::level_start(T_odom_first, up_odom) * prior.T_self_peer;
  KnownLandmark place;
  // Before it moves, its body is at its start: its reported motion is noise.
  const SE3 T_start_body = peer.moved ? peer.pose->T_start_body : SE3{};
  place.p_odom_m = T_odom_start * (T_start_body * p_peer_m);
  // An error of the heading moves the position across the line of sight to it.
  const Vec3 arm = prior.sigma_rad * up_odom.cross(place.p_odom_m - T_odom_first.p);
  const Vec3 rise = level_error_m((place.p_odom_m - T_odom_first.p).norm()) * up_odom;
  place.covariance_m2 = prior.sigma_m * prior.sigma_m * geometry::Mat3::Identity() +
                        arm * arm.transpose() + rise * rise.transpose();
  if (peer.moved) {
    const geometry::Mat3& R = T_odom_start.R;
    place.covariance_m2 += R * peer.pose->position_covariance_m2 * R.transpose();
  }
  return place;
}

}  // namespace rali::vehicle
