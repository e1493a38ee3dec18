#pragma once

#include <optional>
#include <vector>

#include "rali/vehicle/paper_range_stage.hpp"

// A stage of preset `paper` with hand-made scans, for the tests of this folder.
namespace rali::vehicle {

inline const VehicleId kSelf{1};
inline const VehicleId kPeer{0};
/// sqrt(20.5^2 - 1) - 20: from (20, 1) along x onto the circle of 20.5 m (test T9).
inline constexpr double kShift = 0.475595;

/// Unit normals of a scan: `side` on each side wall (y), `floor` on the floor (z), `end` on each
/// end wall (x).
inline std::vector<geometry::Vec3> normals(int side, int floor, int end) {
  std::vector<geometry::Vec3> out;
  out.insert(out.end(), static_cast<std::size_t>(side), geometry::Vec3::UnitY());
  out.insert(out.end(), static_cast<std::size_t>(side), -geometry::Vec3::UnitY());
  out.insert(out.end(), static_cast<std::size_t>(floor), geometry::Vec3::UnitZ());
  out.insert(out.end(), static_cast<std::size_t>(end), geometry::Vec3::UnitX());
  out.insert(out.end(), static_cast<std::size_t>(end), -geometry::Vec3::UnitX());
  return out;
}

/// 4/89 along x, 5/89 - (5/89)^2 along z: degree 1.18, degenerate along x.
inline const std::vector<geometry::Vec3> kCorridor = normals(40, 5, 2);
/// Test T7: degree 3.36, not degenerate.
inline const std::vector<geometry::Vec3> kRoom = normals(40, 16, 2);

/// A stage fed with hand-made scans. The peer stood 1 m to the right of the first pose.
struct Bench {
  VehicleSettings settings;
  std::optional<PaperRangeStage> stage;
  OutputList out;
  const std::vector<geometry::Vec3>* seen = &kCorridor;
  geometry::Vec3 v_mps = geometry::Vec3::Zero();
  bool at_rest = false;
  geometry::Vec3 p_peer{0.0, -1.0, 0.0};

  Bench() {
    PeerSettings peer;
    peer.id = kPeer;
    peer.antennas_body_m = {geometry::Vec3::Zero()};
    settings.peers = {peer};
    settings.odometry.preset = odometry::Preset::kPaper;
    settings.paper_degree = settings.paper_degree.resolved(true);
    settings.ranging.paper.factor = ranging::PaperFactor::kCorrected;
    settings.ranging.paper.gap_m = 0.3;
    settings.ranging.paper.max_s_m = 5.0;
  }

  void begin() {
    PeerPrior prior;
    prior.T_self_peer.p = p_peer;
    settings.peers[0].prior = prior;
    stage.emplace(kSelf, settings);
    stage->on(PeerStatus{kPeer, Time::from_s(0.0), true});
    static_cast<void>(scan(0.1, geometry::Vec3::Zero()));
  }

  /// @return what the keyframe at this pose is moved to
  std::optional<odometry::KeyframeMove> scan(double t_s, const geometry::Vec3& p) {
    odometry::ScanResult scan;
    scan.t = Time::from_s(t_s);
    scan.state = odometry::TrackState::kGood;
    scan.T_odom_body.p = p;
    scan.v_odom_mps = v_mps;
    scan.at_rest = at_rest;
    scan.feature_normals_body = *seen;
    stage->before_scan(scan.t, out);
    odometry::KeyframeInertia inertia;
    inertia.T_odom_body_predicted = scan.T_odom_body;
    const auto move = stage->at_keyframe(scan, inertia);
    if (move) scan.T_odom_body = move->T_odom_body;
    stage->after_scan(scan, out);
    return move;
  }

  /// 20 ranges a second, all the same, the last one at `to_s`.
  void ranges(double from_s, double to_s, double range_m) {
    for (int k = 0; from_s + 0.05 * k < to_s + 1e-6; ++k) {
      const Time t = Time::from_s(from_s + 0.05 * k);
      stage->on(PeerStatus{kPeer, t, true});
      sensor::RangeSample sample;
      sample.t = t;
      sample.from = kSelf;
      sample.to = kPeer;
      sample.range_m = range_m;
      stage->add(sample, out);
    }
  }

  template <class T>
  std::vector<T> all() const {
    std::vector<T> found;
    for (const Output& o : out) {
      if (const T* v = std::get_if<T>(&o)) found.push_back(*v);
    }
    return found;
  }

  int count(ranging::RangeReason reason) const {
    int n = 0;
    for (const ranging::RangeUse& use : all<ranging::RangeUse>()) n += use.reason == reason ? 1 : 0;
    return n;
  }

  /// One keyframe at p, after a second of ranges.
  std::optional<odometry::KeyframeMove> one(const geometry::Vec3& p, double range_m) {
    begin();
    ranges(0.15, 1.1, range_m);
    const auto move = scan(1.1, p);
    stage->flush(out);
    return move;
  }
};

}  // namespace rali::vehicle
