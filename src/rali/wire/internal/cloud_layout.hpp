#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/wire/byte_reader.hpp"
#include "rali/wire/cloud_format.hpp"

namespace rali::wire::internal {

/// Memory layout of a cloud's points, checked against its bytes.
struct CloudLayout {
  std::size_t points = 0;
  std::size_t rows = 0, columns = 0;
  std::size_t row_stride = 0, point_stride = 0;
  std::size_t extent = 0;  ///< minimum bytes of a point: the last one may lack padding

  [[nodiscard]] std::size_t offset(std::size_t row, std::size_t column) const {
    return row * row_stride + column * point_stride;
  }

  /// True if the points are contiguous, without gaps between rows.
  [[nodiscard]] bool flat() const { return rows <= 1 || row_stride == columns * point_stride; }
};

/// Bytes of one value; 0 for types that do not exist.
[[nodiscard]] std::size_t type_size(FieldType type);

/// "uint32", or "type 9" for a type that does not exist.
[[nodiscard]] std::string type_name(FieldType type);

/// Checks size, steps and data for consistency. Errors (kInput) name the contradiction.
[[nodiscard]] Result<CloudLayout> cloud_layout(const CloudView& cloud);

/// True if every point contains the whole field.
[[nodiscard]] bool field_fits(const CloudView& cloud, const CloudField& field);

/// Index of the first field with this name that fits, -1 if there is none.
[[nodiscard]] int find_field(const CloudView& cloud, std::string_view name);

/// Calls f with a value of the C++ type of `type`. The type must exist.
template <class F>
decltype(auto) with_type(FieldType type, F&& f) {
  switch (type) {
    case FieldType::kInt8:
      return f(std::int8_t{});
    case FieldType::kUint8:
      return f(std::uint8_t{});
    case FieldType::kInt16:
      return f(std::int16_t{});
    case FieldType::kUint16:
      return f(std::uint16_t{});
    case FieldType::kInt32:
      return f(std::int32_t{});
    case FieldType::kUint32:
      return f(std::uint32_t{});
    case FieldType::kFloat64:
      return f(double{});
    default:
      return f(float{});
  }
}

/// The values of one field as doubles, every `stride`-th point in order of the data.
[[nodiscard]] std::vector<double> field_values(const CloudView& cloud, const CloudLayout& layout,
                                               int field, std::size_t stride);

}  // namespace rali::wire::internal
