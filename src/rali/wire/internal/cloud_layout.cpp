#include "rali/wire/internal/cloud_layout.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace rali::wire::internal {
namespace {

constexpr std::array<std::string_view, 9> kTypeNames = {
    "type 0", "int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"};
constexpr std::array<std::size_t, 9> kTypeSizes = {0, 1, 1, 2, 2, 4, 4, 4, 8};

// Largest end of a field within the point: the last point of a cloud may end there.
std::size_t fields_end(const CloudView& cloud) {
  std::size_t end = 1;
  for (const CloudField& field : cloud.fields) {
    if (field_fits(cloud, field)) end = std::max(end, field.offset + type_size(field.type));
  }
  return end;
}

Error contradiction(std::string what) {
  return Error{ErrorCode::kInput, std::move(what), {}, "The cloud is left out."};
}

}  // namespace

std::size_t type_size(FieldType type) {
  const auto index = static_cast<std::size_t>(type);
  return index < kTypeSizes.size() ? kTypeSizes[index] : 0;
}

std::string type_name(FieldType type) {
  const auto index = static_cast<std::size_t>(type);
  return index < kTypeNames.size() ? std::string(kTypeNames[index]) : fmt::format("type {}", index);
}

bool field_fits(const CloudView& cloud, const CloudField& field) {
  const std::size_t size = type_size(field.type);
  return size != 0 && size <= cloud.point_step && field.offset <= cloud.point_step - size;
}

int find_field(const CloudView& cloud, std::string_view name) {
  for (std::size_t i = 0; i < cloud.fields.size(); ++i) {
    if (cloud.fields[i].name == name && field_fits(cloud, cloud.fields[i])) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

Result<CloudLayout> cloud_layout(const CloudView& cloud) {
  CloudLayout layout;
  layout.rows = cloud.height;
  layout.columns = cloud.width;
  if (layout.rows == 0 || layout.columns == 0) return layout;
  if (cloud.point_step == 0) {
    return tl::make_unexpected(contradiction("a cloud has points of 0 bytes (point_step)"));
  }
  layout.point_stride = cloud.point_step;
  layout.extent = fields_end(cloud);
  // The product of two 32-bit numbers fits; times point_step it may not, so this divides.
  const std::uint64_t points = std::uint64_t{cloud.height} * cloud.width;
  if (points > cloud.data.size() / layout.extent) {
    return tl::make_unexpected(
        contradiction(fmt::format("a cloud claims {} x {} points of {} bytes, but has {} bytes",
                                  cloud.width, cloud.height, cloud.point_step, cloud.data.size())));
  }
  layout.points = static_cast<std::size_t>(points);
  const std::size_t tight = layout.columns * layout.point_stride;
  // Drivers of unorganised clouds leave row_step 0 or stale: a smaller one is ignored.
  const bool padded = layout.rows > 1 && cloud.row_step > tight;
  layout.row_stride = padded ? cloud.row_step : tight;
  const std::size_t end = layout.offset(layout.rows - 1, layout.columns - 1) + layout.extent;
  if (end > cloud.data.size()) {
    return tl::make_unexpected(contradiction(fmt::format(
        "a cloud of {} x {} points with point_step {} and row_step {} needs {} bytes, "
        "but has {}",
        cloud.width, cloud.height, cloud.point_step, cloud.row_step, end, cloud.data.size())));
  }
  return layout;
}

std::vector<double> field_values(const CloudView& cloud, const CloudLayout& layout, int field,
                                 std::size_t stride) {
  const CloudField& which = cloud.fields[static_cast<std::size_t>(field)];
  std::vector<double> values;
  values.reserve(layout.points / stride + 1);
  with_type(which.type, [&](auto type) {
    using T = decltype(type);
    for (std::size_t i = 0; i < layout.points; i += stride) {
      const std::size_t at = layout.offset(i / layout.columns, i % layout.columns) + which.offset;
      values.push_back(static_cast<double>(load<T>(cloud.data.data() + at, cloud.big_endian)));
    }
  });
  return values;
}

}  // namespace rali::wire::internal
