#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace rali::odometry {

/// How well the first scans fit a first speed after a replay at it.
struct FirstSpeedFit {
  double nis = 0.0;              ///< mean per scan
  double sideways = 0.0;         ///< mean square of the speed across the forward axis, in sigmas
  double on_walls = 0.0;         ///< fraction of a scan's points; half for a wall at 45 degrees
  double on_facing = 0.0;        ///< of these, weighted by how much they face the motion
  double speed_sigma_mps = 0.0;  ///< at the end, along the first heading
  double mean_mps = 0.0;         ///< over all scans, likewise
};

/// Score of a first speed; of two, the one with the higher score is taken. Only surfaces that face
/// the motion distinguish speeds. The ground does not: rings move with the vehicle and fill ever
/// new cells of it. Walls beside the path count as well, since there may be no others. A tenth more
/// points outweigh a mean NIS higher by one, or twice the sigma of the speed: the speed is
/// observable by points that match from scan to scan without moving along.
[[nodiscard]] double value_of(const FirstSpeedFit& fit);

/// A first speed after its replay, if the scans determined the speed.
struct TriedSpeed {
  double first_mps = 0.0;  ///< along the first heading
  double mean_mps = 0.0;   ///< of the replay
  double value = 0.0;
};

/// The one with the highest value. A first speed that is off by its own sigma should lead to the
/// same motion; one that nothing else leads to may be an accident of a young map, e.g. a wall that
/// was mapped twice and fits twice. Of those about as good, one that is reached from another first
/// speed as well is preferred.
/// @param sigma_mps of the first speeds @return its index; nothing if there is none
[[nodiscard]] std::optional<std::size_t> best_speed(std::span<const TriedSpeed> tried,
                                                    double sigma_mps);

}  // namespace rali::odometry
