#pragma once

namespace rali::odometry {

/// How well the first scans fit a first speed, after they have been gone through at it.
struct FirstSpeedFit {
  double nis = 0.0;              ///< mean of a scan
  double sideways = 0.0;         ///< mean square of the speed across the body's x, in sigmas
  double on_walls = 0.0;         ///< ratio of a scan's points; half for a wall at 45 degrees
  double on_facing = 0.0;        ///< of these, as far as they face the motion
  double speed_sigma_mps = 0.0;  ///< at the end, along the first heading
};

/// Of two first speeds the one with the higher value is taken. Only surfaces that face a motion
/// tell it from another, the ground of a vehicle none: rings that drive along with the vehicle fill
/// ever new cells of it. Walls beside the way are counted as well, since there may be no others. A
/// tenth more points outweigh a mean NIS higher by one, or a speed known half as well: what is seen
/// again from scan to scan, and not dragged along, makes it known.
[[nodiscard]] double value_of(const FirstSpeedFit& fit);

}  // namespace rali::odometry
