#include "rali/io/files/mesh_file.hpp"

#include <algorithm>

#include <fmt/core.h>

#include "rali/io/files/input_file.hpp"
#include "rali/io/files/text.hpp"

namespace rali::io {
namespace {

Status check(const MeshFile& mesh, const std::string& path) {
  if (mesh.triangles.empty()) {
    return fail(ErrorCode::kInput, path, "the mesh has no triangles",
                "Export surfaces, not points or lines.");
  }
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (mesh.vertices[i].allFinite()) continue;
    return fail(ErrorCode::kInput, path,
                fmt::format("vertex {} has a coordinate that is no finite number", i));
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const std::uint32_t v : mesh.triangles[i]) {
      if (v < mesh.vertices.size()) continue;
      return fail(
          ErrorCode::kInput, path,
          fmt::format("triangle {} names vertex {}, but there are {}", i, v, mesh.vertices.size()));
    }
  }
  for (std::size_t i = 0; i < mesh.reflectivity.size(); ++i) {
    if (mesh.reflectivity[i] >= 0.0F && mesh.reflectivity[i] <= 1.0F) continue;
    return fail(ErrorCode::kInput, path,
                fmt::format("triangle {} has reflectivity {}, not 0 to 1", i, mesh.reflectivity[i]),
                "Scale the property, or leave it out.");
  }
  return {};
}

}  // namespace

Result<MeshFile> parse_mesh_file(std::span<const std::byte> bytes, const std::string& path) {
  const std::string lower = lower_case(path);
  const auto parsed = [&]() -> Result<MeshFile> {
    if (lower.ends_with(".ply")) return parse_mesh_ply(bytes, path);
    if (lower.ends_with(".obj")) return parse_mesh_obj(bytes, path);
    if (lower.ends_with(".stl")) return parse_mesh_stl(bytes, path);
    return fail(ErrorCode::kInput, path, "is no mesh by its name",
                "Files end with .ply, .obj or .stl.");
  };
  auto mesh = parsed();
  if (!mesh) return mesh;
  if (auto status = check(*mesh, path); !status) return tl::make_unexpected(status.error());
  return mesh;
}

Result<MeshFile> read_mesh_file(const std::string& path) {
  const auto bytes = read_file(path, kMeshBytesMax);
  if (!bytes) return tl::make_unexpected(bytes.error());
  return parse_mesh_file(*bytes, path);
}

}  // namespace rali::io
