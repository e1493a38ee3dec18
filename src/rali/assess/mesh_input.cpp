#include "rali/assess/mesh_input.hpp"

#include <utility>

#include "rali/io/files/mesh_file.hpp"

namespace rali::assess {

Result<eval::TriangleMesh> read_mesh(const std::string& path) {
  Result<io::MeshFile> file = io::read_mesh_file(path);
  if (!file) return tl::make_unexpected(file.error());
  eval::TriangleMesh mesh;
  mesh.vertices.reserve(file->vertices.size());
  for (const geometry::Vec3f& v : file->vertices) mesh.vertices.push_back(v.cast<double>());
  mesh.triangles = std::move(file->triangles);
  if (Status s = eval::check_mesh(mesh, path); !s) return tl::make_unexpected(s.error());
  return mesh;
}

}  // namespace rali::assess
