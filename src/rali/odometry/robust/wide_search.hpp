#pragma once

#include <vector>

#include "rali/odometry/robust/coarse_search.hpp"

namespace rali::odometry {

/// As search_pose(), with the best of `candidates` headings: for a guess that may be turned by any
/// angle, where many headings fit to some degree.
[[nodiscard]] std::vector<geometry::SE3> search_headings(
    const RecentPoints& recent, const BodyPoints& points, const PoseGuess& guess,
    const geometry::Vec3& up_odom, const CoarseSearchSettings& settings, std::size_t candidates);

/// As search_pose(), with the best of `candidates` that are farther apart than `apart_m` or turned
/// by more than three steps of the grid: for a guess so poor that other places may look alike. The
/// cells grow with the reach, so that the number of trials stays bounded.
[[nodiscard]] std::vector<geometry::SE3> search_places(const RecentPoints& recent,
                                                       const BodyPoints& points,
                                                       const PoseGuess& guess,
                                                       const geometry::Vec3& up_odom,
                                                       const CoarseSearchSettings& settings,
                                                       double apart_m, std::size_t candidates);

}  // namespace rali::odometry
