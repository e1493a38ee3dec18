#pragma once

#include <span>

#include "rali/geometry/se3.hpp"
#include "rali/monitor/contradiction.hpp"
#include "rali/monitor/settings.hpp"

namespace rali::monitor {

/// A pose with its uncertainty, as one estimate states it.
struct StatedPose {
  Time t;
  geometry::SE3 T;
  geometry::Mat3 position_covariance = geometry::Mat3::Zero();  ///< in the frame of T [m^2]
};

/// Two estimates of one path: where does the judged one lie off the reference by more than it
/// states? Compared are positions, at the stamps of the judged poses that lie between two reference
/// poses at most 1 s apart. Where the reference itself is not sure to the distance, it contradicts
/// nothing.
/// @param judged, reference  by time
/// @param T_reference_judged  how the frames lie to each other
[[nodiscard]] ContradictionList check_track(std::span<const StatedPose> judged,
                                            std::span<const StatedPose> reference,
                                            const geometry::SE3& T_reference_judged,
                                            const MonitorSettings& settings);

/// The frames' relative pose if both agree at the first pose that they have in common (1 ms);
/// the identity if there is none.
[[nodiscard]] geometry::SE3 agreeing_at_first(std::span<const StatedPose> judged,
                                              std::span<const StatedPose> reference);

}  // namespace rali::monitor
