#pragma once

#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/eval/association.hpp"

namespace rali::assess {

/// `<v>.cov.csv` as geometry::boxplus has it, one matrix per pose by its stamp, all NaN where the
/// table has no row or an incomplete one. Errors: kInput (no table, columns missing).
[[nodiscard]] Result<std::vector<geometry::Mat6>> read_covariances(const std::string& path,
                                                                   const eval::PoseList& poses);

/// `degeneracy/<v>.csv`: the blind direction in map, one per pose by its stamp; zero where the
/// vehicle was not blind or the direction is not known. Errors: as read_covariances().
[[nodiscard]] Result<std::vector<geometry::Vec3>> read_blind_directions(
    const std::string& path, const eval::PoseList& poses);

}  // namespace rali::assess
