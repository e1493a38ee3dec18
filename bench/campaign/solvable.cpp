#include "solvable.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace rali::campaign {

namespace {

/// Fraction of the samples in which the rotation or acceleration exceeds the sensor's limits.
double saturated_ratio(const Case& c, const Track& track) {
  const sim::ImuOptions& imu = c.setup.fleet.vehicle.imu;
  std::size_t over = 0;
  for (const sensor::ImuSample& s : track.imu) {
    const bool gyro = (s.gyro_radps.array().abs() > 0.999 * imu.gyro_limit_radps).any();
    const bool accel = (s.accel_mps2.array().abs() > 0.999 * imu.accel_limit_mps2).any();
    over += gyro || accel ? 1 : 0;
  }
  return track.imu.empty() ? 0.0
                           : static_cast<double>(over) / static_cast<double>(track.imu.size());
}

/// A tunnel that is degenerate along its axis.
bool featureless(const Case& c) {
  constexpr double kFarApart_m = 40.0;
  constexpr double kRough_m = 0.03;
  if (c.setup.place != scenario::PlaceKind::kTunnel) return false;
  const sim::TunnelOptions& t = c.setup.tunnel;
  const bool cabinets = t.cabinet_every_m > 0.0 && t.cabinet_every_m < kFarApart_m;
  const bool niches = t.niche_every_m > 0.0 && t.niche_every_m < kFarApart_m;
  return !cabinets && !niches && t.roughness_m < kRough_m;
}

bool alone(const Recording& recording, const Track& track) {
  constexpr double kSaturated = 0.02;
  constexpr double kFast_mps = 1.5;
  const Case& c = recording.description();
  if (c.has_imu()) return saturated_ratio(c, track) < kSaturated;
  double longest_s = 0.0;
  for (const auto* spans : {&c.lidar_missing, &c.lidar_covered}) {
    for (const Span& span : *spans) longest_s = std::max(longest_s, span.end_s - span.start_s);
  }
  return !featureless(c) && c.setup.fleet.vehicle.motion.speed_mps < kFast_mps && longest_s < 0.5;
}

/// True if both vehicles passed common ground; the direction of travel does not matter.
bool overlap(const Track& a, const Track& b) {
  constexpr double kNear_m = 4.0;
  constexpr std::size_t kStep = 25;  // 0.5 s
  constexpr int kPlaces = 12;
  int places = 0;
  for (std::size_t i = 0; i < a.truth.size(); i += kStep) {
    double nearest = 1e9;
    for (std::size_t k = 0; k < b.truth.size(); k += kStep) {
      nearest = std::min(nearest, (a.truth[i].T.p - b.truth[k].T.p).norm());
    }
    places += nearest < kNear_m ? 1 : 0;
  }
  return places >= kPlaces;
}

/// True if the pairs for which `joined` is true connect all vehicles.
template <class Joined>
bool connected(std::size_t n, const Joined& joined) {
  std::vector<std::size_t> open{0};
  std::vector<bool> seen(n, false);
  seen[0] = true;
  while (!open.empty()) {
    const std::size_t a = open.back();
    open.pop_back();
    for (std::size_t b = 0; b < n; ++b) {
      if (seen[b] || !joined(a, b)) continue;
      seen[b] = true;
      open.push_back(b);
    }
  }
  return std::all_of(seen.begin(), seen.end(), [](bool s) { return s; });
}

bool joint(const Recording& recording) {
  const Case& c = recording.description();
  const std::vector<Track>& tracks = recording.tracks();
  if (tracks.size() < 2 || c.prior_kind == "good") return true;
  // A prior with an error beyond its sigma is a contradiction: the right answer may be separate
  // maps.
  if (c.prior_kind == "wrong") return false;
  if (featureless(c) || !c.has_imu()) return false;
  return connected(tracks.size(), [&](std::size_t a, std::size_t b) {
    return a != b && overlap(tracks[a], tracks[b]);
  });
}

}  // namespace

Solvable judge_solvable(const Recording& recording) {
  Solvable out;
  for (const Track& track : recording.tracks()) out.alone = out.alone && alone(recording, track);
  out.joint = out.alone && joint(recording);
  return out;
}

}  // namespace rali::campaign
