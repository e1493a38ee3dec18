#pragma once

#include <string>

#include "rali/base/result.hpp"
#include "rali/eval/mesh.hpp"

namespace rali::assess {

/// A mesh of a PLY, OBJ or STL file, checked. Errors: kInput with file and line or offset.
[[nodiscard]] Result<eval::TriangleMesh> read_mesh(const std::string& path);

}  // namespace rali::assess
