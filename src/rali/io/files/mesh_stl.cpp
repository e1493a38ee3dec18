#include <cstring>
#include <limits>

#include <fmt/core.h>

#include "rali/io/files/input_file.hpp"
#include "rali/io/files/mesh_file.hpp"
#include "rali/io/files/text.hpp"

namespace rali::io {
namespace {

constexpr std::size_t kHeaderBytes = 84;
constexpr std::size_t kFacetBytes = 50;

std::uint32_t little_u32(std::span<const std::byte> bytes) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data(), sizeof value);
  return value;
}

void add_facet(MeshFile& mesh) {
  const auto n = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.triangles.push_back({n - 3, n - 2, n - 1});
}

MeshFile binary(std::span<const std::byte> facets) {
  MeshFile mesh;
  mesh.vertices.reserve(facets.size() / kFacetBytes * 3);
  mesh.triangles.reserve(facets.size() / kFacetBytes);
  for (; facets.size() >= kFacetBytes; facets = facets.subspan(kFacetBytes)) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      float p[3];
      std::memcpy(p, facets.data() + 12 + 12 * corner, sizeof p);
      mesh.vertices.emplace_back(p[0], p[1], p[2]);
    }
    add_facet(mesh);
  }
  return mesh;
}

tl::unexpected<Error> error(const std::string& path, std::size_t line, std::string what) {
  return fail(ErrorCode::kInput, fmt::format("{}:{}", path, line), std::move(what));
}

/// A facet is the three `vertex` lines between `outer loop` and `endloop`.
Result<MeshFile> ascii(std::string_view rest, const std::string& path) {
  MeshFile mesh;
  std::string_view line;
  std::size_t corners = 0;
  std::size_t number = 0;
  bool in_loop = false;
  while (take_line(rest, line)) {
    ++number;
    const std::string word = lower_case(take_word(line));
    if (word == "vertex") {
      geometry::Vec3f p;
      for (int axis = 0; axis < 3; ++axis) {
        const std::string_view text = take_word(line);
        const auto value = parse_number(text);
        if (!value) return error(path, number, fmt::format("{} is no coordinate", quoted(text)));
        p[axis] = static_cast<float>(*value);
      }
      if (!in_loop || ++corners > 3) return error(path, number, "a facet has three vertices");
      mesh.vertices.push_back(p);
    } else if (word == "outer") {
      if (in_loop) return error(path, number, "the facet before has no endloop");
      in_loop = true;
      corners = 0;
    } else if (word == "endloop") {
      if (!in_loop || corners != 3) return error(path, number, "a facet has three vertices");
      in_loop = false;
      add_facet(mesh);
    } else if (!word.empty() && word != "solid" && word != "endsolid" && word != "facet" &&
               word != "endfacet") {
      return error(path, number, fmt::format("{} is no word of an STL file", quoted(word)));
    }
  }
  if (in_loop) return error(path, number, "is cut in the midst of a facet");
  return mesh;
}

}  // namespace

Result<MeshFile> parse_mesh_stl(std::span<const std::byte> bytes, const std::string& path) {
  // Some programs begin binary files with "solid", so the length is checked first.
  if (bytes.size() >= kHeaderBytes) {
    const std::uint64_t facets = little_u32(bytes.subspan(80));
    if (bytes.size() - kHeaderBytes == facets * kFacetBytes) {
      return binary(bytes.subspan(kHeaderBytes));
    }
  }
  std::string_view text = as_text(bytes);
  std::string_view line;
  if (take_line(text, line) && lower_case(take_word(line)) == "solid")
    return ascii(as_text(bytes), path);
  if (bytes.size() < kHeaderBytes) {
    return fail(ErrorCode::kInput, path, "is cut: an STL file has a header of 84 bytes");
  }
  return fail(ErrorCode::kInput, path,
              fmt::format("says {} triangles, but has {} bytes for them",
                          little_u32(bytes.subspan(80)), bytes.size() - kHeaderBytes),
              "The file is cut, or no STL.");
}

}  // namespace rali::io
