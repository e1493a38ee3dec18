#pragma once

#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/eval/association.hpp"

namespace rali::assess {

/// `<v>.cov.csv` in the convention of geometry::boxplus, one matrix per pose by its stamp, all NaN
/// where the table has no row or an incomplete one. Errors: kInput (no table, columns missing).
[[nodiscard]] Result<std::vector<geometry::Mat6>> read_covariances(const std::string& path,
                                                                   const eval::PoseList& poses);

/// `degeneracy/<v>.csv`: the degenerate direction in map, one per pose by its stamp; zero where the
/// vehicle was not degenerate or the direction is unknown. Errors: as read_covariances().
[[nodiscard]] Result<std::vector<geometry::Vec3>> read_degenerate_directions(
    const std::string& path, const eval::PoseList& poses);

}  // namespace rali::assess
