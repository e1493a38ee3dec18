#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/geometry/se3.hpp"

namespace rali::io {

/// One column of a PCD file as its header declares it.
struct PcdColumn {
  std::string name;         ///< "_" is padding
  std::uint32_t size = 4;   ///< bytes of one element: 1, 2, 4, 8
  char type = 'F';          ///< I, U or F
  std::uint32_t count = 1;  ///< elements a point
};

enum class PcdEncoding { kAscii, kBinary, kCompressed };

struct PcdHeader {
  std::vector<PcdColumn> columns;
  std::uint64_t width = 0, height = 1, points = 0;
  std::uint64_t point_step = 0;  ///< bytes of one point in the file, padding included
  std::optional<geometry::SE3> viewpoint;
  PcdEncoding encoding = PcdEncoding::kAscii;
  std::size_t data_offset = 0;  ///< where the points begin
  std::size_t data_line = 0;    ///< line number of the first point of an ascii file
  std::string note;             ///< contradictions in the header and how they were resolved; may be
                                ///< empty
};

/// Reads the header. Format: https://pointclouds.org/documentation/tutorials/pcd_file_format.html.
/// Errors: kInput with file and line.
[[nodiscard]] Result<PcdHeader> parse_pcd_header(std::span<const std::byte> bytes,
                                                 const std::string& path);

}  // namespace rali::io
