#include "rali/vehicle/peer_places.hpp"

#include "rali/fleet/path/level.hpp"

namespace rali::vehicle {

using geometry::SE3;
using geometry::Vec3;

void PeerWatch::on(const PeerStatus& status) {
  if (heard && status.t < t_status) return;
  heard = true;
  t_status = status.t;
  if (at_rest && !status.at_rest) moved = true;
  at_rest = status.at_rest;
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

Vec3 place_of(const PeerPrior& prior, const Vec3& p_peer_m, const SE3& T_odom_first,
              const Vec3& up_odom) {
  return fleet::level_start(T_odom_first, up_odom) * (prior.T_self_peer * p_peer_m);
}

}  // namespace rali::vehicle
