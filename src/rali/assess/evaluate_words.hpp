#pragma once

#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/eval/association.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::assess {

/// "1,10,50" as distances [m], each above 0, at most 16, without doubles. Errors: kUsage.
[[nodiscard]] Result<std::vector<double>> parse_distances(const std::string& text);

/// "interpolate" or "nearest:SECONDS" ("nearest": 0.01 s). Errors: kUsage.
[[nodiscard]] Result<eval::AssociationOptions> parse_association(const std::string& text);

/// "x,y,z,roll,pitch,yaw" in m and deg, R = Rz(yaw) Ry(pitch) Rx(roll). Errors: kUsage.
[[nodiscard]] Result<geometry::SE3> parse_pose(const std::string& text);

}  // namespace rali::assess
