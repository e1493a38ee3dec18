// Mesh files of any content, all three formats: no crash, no hang, and every index is valid.
#include <cstdint>
#include <span>

#include "rali/base/assert.hpp"
#include "rali/io/files/mesh_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  for (const char* name : {"fuzz.ply", "fuzz.obj", "fuzz.stl"}) {
    const auto mesh = rali::io::parse_mesh_file(bytes, name);
    if (!mesh) {
      RALI_ASSERT(!mesh.error().message().empty());
      continue;
    }
    RALI_ASSERT(!mesh->triangles.empty());
    RALI_ASSERT(mesh->reflectivity.empty() || mesh->reflectivity.size() == mesh->triangles.size());
    for (const float r : mesh->reflectivity) RALI_ASSERT(r >= 0.0F && r <= 1.0F);
    for (const auto& triangle : mesh->triangles) {
      for (const std::uint32_t v : triangle) RALI_ASSERT(v < mesh->vertices.size());
    }
  }
  return 0;
}
