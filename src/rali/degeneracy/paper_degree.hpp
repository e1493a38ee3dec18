#pragma once

#include <span>

#include "rali/degeneracy/paper_settings.hpp"
#include "rali/degeneracy/report.hpp"

namespace rali::degeneracy {

/// The paper's degree of degeneracy from the unit normals of one scan's planar features.
///
/// @param normals_body unit normals in the body frame; normals that are not finite are ignored.
/// @param up_body unit vector against gravity in the body frame; needed for horizontal ratios and
///        directions.
/// @return `known` is false, and `degenerate` true, with fewer than deg_min_normals normals. With
///         lambda3 = 0 the degree is infinite. `direction_known` is false if the setting yields no
///         direction: then a caller must not correct along any.
/// Source: paper, section "Geometry-based Degeneration Detection"; algorithms.md 3.1.
[[nodiscard]] PaperDegree paper_degree(std::span<const geometry::Vec3> normals_body,
                                       const geometry::Vec3& up_body,
                                       const PaperDegreeSettings& settings);

}  // namespace rali::degeneracy
