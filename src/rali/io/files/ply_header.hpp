#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/wire/cloud_format.hpp"

namespace rali::io {

struct PlyProperty {
  std::string name;
  wire::FieldType type = wire::FieldType::kFloat32;  ///< of one element
  std::optional<wire::FieldType> list_count;         ///< set: a list, its length of this type
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  [[nodiscard]] bool has_lists() const;
  /// Bytes of the properties that are not lists.
  [[nodiscard]] std::uint64_t fixed_bytes() const;
  /// Minimum number of bytes of a row in a binary file: lists may be empty.
  [[nodiscard]] std::uint64_t bytes_min() const;
};

enum class PlyEncoding { kAscii, kBinaryLittle, kBinaryBig };

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kAscii;
  std::vector<PlyElement> elements;
  std::size_t data_offset = 0;
  std::size_t data_line = 0;
};

/// Reads the header. Format: Greg Turk, "The PLY Polygon File Format", 1994.
/// Errors: kInput with file and line.
[[nodiscard]] Result<PlyHeader> parse_ply_header(std::span<const std::byte> bytes,
                                                 const std::string& path);

}  // namespace rali::io
