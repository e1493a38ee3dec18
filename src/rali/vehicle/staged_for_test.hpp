#pragma once

#include <vector>

#include "rali/odometry/augmented_filter_for_test.hpp"
#include "rali/vehicle/range_stage.hpp"

namespace rali::vehicle {

inline constexpr VehicleId kSelf{1};
inline constexpr VehicleId kPeer{2};
inline const geometry::Vec3 kGravity(0.0, 0.0, -9.81);

/// A peer with a prior 10 m ahead: sigma 0.2 m, and 0.05 rad in direction.
inline VehicleSettings settings_with_prior() {
  VehicleSettings settings;
  PeerSettings peer;
  peer.id = kPeer;
  peer.antennas_body_m = {geometry::Vec3::Zero()};
  peer.prior.emplace();
  peer.prior->T_self_peer.p = geometry::Vec3(10.0, 0.0, 0.0);
  settings.peers.push_back(peer);
  return settings;
}

/// A vehicle at the origin of odom at t = 0 that drives 1 m/s along x, with a position sigma
/// of 0.2 m along x.
struct Staged {
  odometry::DenseAugmentedFilter filter;
  RangeStage stage;
  OutputList out;
  RangeEffect effect;

  explicit Staged(const VehicleSettings& settings = settings_with_prior())
      : stage(kSelf, settings) {
    filter.P.diagonal().segment<3>(3) << 0.04, 1e-4, 1e-4;
    filter.now.v_odom_mps = geometry::Vec3::UnitX();
    report(0.0, true);
  }

  void report(double t_s, bool at_rest) { stage.on(PeerStatus{kPeer, Time::from_s(t_s), at_rest}); }

  static sensor::RangeSample sample(double t_s, double range_m) {
    sensor::RangeSample s;
    s.t = Time::from_s(t_s);
    s.from = kSelf;
    s.to = kPeer;
    s.range_m = range_m;
    return s;
  }

  void add(double t_s, double range_m) { stage.add(sample(t_s, range_m), out); }

  void run(double t_s) {
    effect = stage.run(Time::from_s(t_s), &filter, kGravity, geometry::SE3{}, out);
  }

  /// Feeds one more range. @return its outcome
  ranging::RangeUse one(double t_s, double range_m) {
    add(t_s, range_m);
    run(t_s);
    return uses().back();
  }

  [[nodiscard]] std::vector<ranging::RangeUse> uses() const {
    std::vector<ranging::RangeUse> found;
    for (const Output& o : out) {
      if (const auto* use = std::get_if<ranging::RangeUse>(&o)) found.push_back(*use);
    }
    return found;
  }
};

}  // namespace rali::vehicle
