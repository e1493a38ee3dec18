#pragma once

#include <vector>

#include "rali/odometry/robust/coarse_search.hpp"

namespace rali::odometry {

/// As search_pose(), with the best of `candidates` headings: for a guess that may be turned by any
/// angle, where many headings fit to some degree.
[[nodiscard]] std::vector<geometry::SE3> search_headings(
    const RecentPoints& recent, const BodyPoints& points, const PoseGuess& guess,
    const geometry::Vec3& up_odom, const CoarseSearchSettings& settings, std::size_t candidates);

}  // namespace rali::odometry
