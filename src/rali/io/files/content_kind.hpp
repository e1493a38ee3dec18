#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace rali::io {

/// Kind of a file by its first bytes, as words for an error message: "a ROS bag", "an empty file",
/// "text"; "binary data of unknown kind" if not recognised.
[[nodiscard]] std::string content_kind(std::span<const std::byte> head);

/// True where the bytes begin a PCD file (its first keyword or its usual first comment).
[[nodiscard]] bool begins_pcd(std::span<const std::byte> head);

/// True where the bytes begin a PLY file.
[[nodiscard]] bool begins_ply(std::span<const std::byte> head);

/// True where the bytes begin a LAS file.
[[nodiscard]] bool begins_las(std::span<const std::byte> head);

/// True if these bytes are a known kind of file or printable text, so not raw numbers.
[[nodiscard]] bool has_known_kind(std::span<const std::byte> head);

}  // namespace rali::io
