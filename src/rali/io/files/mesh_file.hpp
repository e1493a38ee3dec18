#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/geometry/types.hpp"

namespace rali::io {

/// A triangle mesh of a file; polygons are split into fans. Every index is valid and
/// every coordinate finite.
struct MeshFile {
  std::vector<geometry::Vec3f> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<float> reflectivity;  ///< per triangle, 0..1; empty if the file has none
};

/// Larger files are refused.
inline constexpr std::uint64_t kMeshBytesMax = 1ULL << 29U;

/// Reads PLY (ascii, both binaries), OBJ or STL (ascii, binary), distinguished by the file
/// extension.
/// Errors: kInput, with file and line or offset: missing, another extension, truncated, an index
/// that names no vertex, a coordinate that is no number, a reflectivity beyond 0..1, no triangle.
[[nodiscard]] Result<MeshFile> read_mesh_file(const std::string& path);

/// The same from memory; `path` is for messages and its extension.
[[nodiscard]] Result<MeshFile> parse_mesh_file(std::span<const std::byte> bytes,
                                               const std::string& path);

/// Elements `vertex` (x, y, z) and `face` (a list vertex_indices or vertex_index; a scalar
/// `reflectivity` if there is one); everything else is ignored.
[[nodiscard]] Result<MeshFile> parse_mesh_ply(std::span<const std::byte> bytes,
                                              const std::string& path);
/// Lines `v` and `f`, negative indices too; everything else is ignored.
[[nodiscard]] Result<MeshFile> parse_mesh_obj(std::span<const std::byte> bytes,
                                              const std::string& path);
/// Binary if the length matches the triangle count in the header, else text. Three vertices for
/// each triangle; normals and attributes are ignored.
[[nodiscard]] Result<MeshFile> parse_mesh_stl(std::span<const std::byte> bytes,
                                              const std::string& path);

/// truth/mesh.ply (product.md section 9): binary little endian, vertices as float32, faces as
/// `list uchar int vertex_indices` with `reflectivity` where given (empty, or one per triangle).
[[nodiscard]] Status write_mesh_ply(const std::string& path,
                                    std::span<const geometry::Vec3f> vertices,
                                    std::span<const std::array<std::uint32_t, 3>> triangles,
                                    std::span<const float> reflectivity);

}  // namespace rali::io
