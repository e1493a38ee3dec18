#pragma once

#include <span>

#include "rali/geometry/se3.hpp"
#include "rali/monitor/contradiction.hpp"
#include "rali/monitor/settings.hpp"

namespace rali::monitor {

/// A pose with its covariance, as stated by one estimate.
struct StatedPose {
  Time t;
  geometry::SE3 T;
  geometry::Mat3 position_covariance = geometry::Mat3::Zero();  ///< in the frame of T [m^2]
};

/// Compares two estimates of one path: intervals in which the checked one differs from the
/// reference by more than its covariance allows. It compares positions, at those stamps of the
/// checked poses that lie between two reference poses at most 1 s apart. A reference whose sigma
/// exceeds the difference contradicts nothing.
/// @param judged, reference  by time
/// @param T_reference_judged  relative pose of the frames
[[nodiscard]] ContradictionList check_track(std::span<const StatedPose> judged,
                                            std::span<const StatedPose> reference,
                                            const geometry::SE3& T_reference_judged,
                                            const MonitorSettings& settings);

/// The frames' relative pose if both agree at the first pose that they have in common (1 ms);
/// the identity if there is none.
[[nodiscard]] geometry::SE3 agreeing_at_first(std::span<const StatedPose> judged,
                                              std::span<const StatedPose> reference);

}  // namespace rali::monitor
