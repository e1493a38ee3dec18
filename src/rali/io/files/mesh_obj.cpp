#include <limits>
#include <optional>

#include <fmt/core.h>

#include "rali/io/files/input_file.hpp"
#include "rali/io/files/mesh_file.hpp"
#include "rali/io/files/text.hpp"

namespace rali::io {
namespace {

class ObjReader {
 public:
  ObjReader(std::string_view text, const std::string& path) : rest_(text), path_(path) {}

  Result<MeshFile> read() {
    std::string_view line;
    while (take_line(rest_, line)) {
      ++line_;
      const std::string_view word = take_word(line);
      Status status;
      if (word == "v") status = take_vertex(line);
      if (word == "f") status = take_face(line);
      if (!status) return tl::make_unexpected(status.error());
    }
    return std::move(mesh_);
  }

 private:
  Status take_vertex(std::string_view line) {
    geometry::Vec3f p;
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view text = take_word(line);
      const auto value = parse_number(text);
      if (!value) return error(fmt::format("{} is no coordinate", quoted(text)));
      p[axis] = static_cast<float>(*value);
    }
    mesh_.vertices.push_back(p);
    return {};
  }

  /// "12", "12/3", "12//4", "-1": the first number is an index from 1, or negative from the last
  /// vertex.
  [[nodiscard]] std::optional<std::uint32_t> index_of(std::string_view word) const {
    const auto number = parse_integer(word.substr(0, word.find('/')));
    const auto have = static_cast<std::int64_t>(mesh_.vertices.size());
    if (!number || *number > have || *number < -have || *number == 0) return std::nullopt;
    return static_cast<std::uint32_t>(*number > 0 ? *number - 1 : have + *number);
  }

  Status take_face(std::string_view line) {
    std::uint32_t first = 0;
    std::uint32_t last = 0;
    std::size_t corners = 0;
    while (true) {
      const std::string_view word = take_word(line);
      if (word.empty()) break;
      const auto index = index_of(word);
      if (!index) {
        return error(fmt::format("{} names none of the {} vertices so far", quoted(word),
                                 mesh_.vertices.size()));
      }
      if (corners == 0) first = *index;
      if (corners >= 2) mesh_.triangles.push_back({first, last, *index});
      last = *index;
      ++corners;
    }
    if (corners < 3) return error(fmt::format("a face has {} corners", corners));
    return {};
  }

  tl::unexpected<Error> error(std::string what) const {
    return fail(ErrorCode::kInput, fmt::format("{}:{}", path_, line_), std::move(what));
  }

  std::string_view rest_;
  const std::string& path_;
  std::size_t line_ = 0;
  MeshFile mesh_;
};

}  // namespace

Result<MeshFile> parse_mesh_obj(std::span<const std::byte> bytes, const std::string& path) {
  return ObjReader(as_text(bytes), path).read();
}

}  // namespace rali::io
