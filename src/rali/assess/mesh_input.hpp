#pragma once

#include <string>

#include "rali/base/result.hpp"
#include "rali/eval/mesh.hpp"

namespace rali::assess {

/// Reads and checks a mesh from a PLY, OBJ or STL file. Errors: kInput with file and line or
/// offset.
[[nodiscard]] Result<eval::TriangleMesh> read_mesh(const std::string& path);

}  // namespace rali::assess
