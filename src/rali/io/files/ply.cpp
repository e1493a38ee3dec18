#include <algorithm>
#include <cstring>
#include <utility>

#include <fmt/core.h>

#include "rali/io/files/ascii_value.hpp"
#include "rali/io/files/cloud_file.hpp"
#include "rali/io/files/input_file.hpp"
#include "rali/io/files/ply_header.hpp"
#include "rali/io/files/text.hpp"

namespace rali::io {
namespace {

/// CloudCompare names every extra column scalar_..., with arbitrary capitals.
std::string field_name(const std::string& property) {
  const std::string lower = lower_case(property);
  constexpr std::string_view kPrefix = "scalar_";
  return lower.starts_with(kPrefix) && lower.size() > kPrefix.size() ? lower.substr(kPrefix.size())
                                                                     : property;
}

tl::unexpected<Error> cut(const std::string& path, const PlyElement& element, std::uint64_t have) {
  return fail(ErrorCode::kInput, path,
              fmt::format("is cut: {} of {} rows of element {} are there", have, element.count,
                          quoted(element.name)));
}

/// Reads the rows of a binary file.
class BinaryRows {
 public:
  BinaryRows(std::span<const std::byte> bytes, bool big_endian, const std::string& path)
      : rest_(bytes), big_endian_(big_endian), path_(path) {}

  /// Skips an element; keeps its non-list properties in `keep` if given, little endian and packed.
  Status read(const PlyElement& element, std::vector<std::byte>* keep) {
    if (element.properties.empty()) return {};
    const std::uint64_t minimum = element.bytes_min();
    if (element.count > rest_.size() / minimum) return cut(path_, element, rest_.size() / minimum);
    if (!element.has_lists() && keep == nullptr) {
      rest_ = rest_.subspan(static_cast<std::size_t>(element.count * minimum));
      return {};
    }
    if (keep != nullptr) {
      keep->reserve(static_cast<std::size_t>(element.count * element.fixed_bytes()));
    }
    for (std::uint64_t row = 0; row < element.count; ++row) {
      if (!read_row(element, keep)) return cut(path_, element, row);
    }
    return {};
  }

 private:
  bool read_row(const PlyElement& element, std::vector<std::byte>* keep) {
    for (const PlyProperty& property : element.properties) {
      if (property.list_count) {
        if (!pass_list(property)) return false;
        continue;
      }
      const std::size_t bytes = field_bytes(property.type);
      if (rest_.size() < bytes) return false;
      if (keep != nullptr) append(rest_.first(bytes), *keep);
      rest_ = rest_.subspan(bytes);
    }
    return true;
  }

  bool pass_list(const PlyProperty& property) {
    const std::size_t bytes = field_bytes(*property.list_count);
    if (rest_.size() < bytes) return false;
    std::uint64_t n = 0;
    for (std::size_t i = 0; i < bytes; ++i) {
      const std::size_t from = big_endian_ ? i : bytes - 1 - i;
      n = (n << 8) | std::to_integer<std::uint64_t>(rest_[from]);
    }
    rest_ = rest_.subspan(bytes);
    // A negative length has its highest bit set and so exceeds any file size.
    const std::uint64_t element = field_bytes(property.type);
    if (n > rest_.size() / element) return false;
    rest_ = rest_.subspan(static_cast<std::size_t>(n * element));
    return true;
  }

  void append(std::span<const std::byte> value, std::vector<std::byte>& keep) const {
    if (big_endian_) {
      keep.insert(keep.end(), value.rbegin(), value.rend());
    } else {
      keep.insert(keep.end(), value.begin(), value.end());
    }
  }

  std::span<const std::byte> rest_;
  bool big_endian_;
  const std::string& path_;
};

/// Reads the rows of an ascii file: one line each.
class AsciiRows {
 public:
  AsciiRows(std::string_view text, std::size_t first_line, const std::string& path)
      : rest_(text), line_(first_line - 1), ends_whole_(text.ends_with('\n')), path_(path) {}

  Status read(const PlyElement& element, std::vector<std::byte>* keep) {
    if (element.properties.empty()) return {};
    std::string_view line;
    for (std::uint64_t row = 0; row < element.count; ++row) {
      if (!take_filled_line(line)) return cut(path_, element, row);
      if (keep == nullptr) continue;
      if (auto wrong = append_row(element, line, *keep)) {
        if (rest_.empty() && !ends_whole_) return cut(path_, element, row);
        return fail(ErrorCode::kInput, fmt::format("{}:{}", path_, line_), *wrong);
      }
    }
    return {};
  }

 private:
  bool take_filled_line(std::string_view& line) {
    while (take_line(rest_, line)) {
      ++line_;
      if (!trimmed(line).empty()) return true;
    }
    return false;
  }

  static std::optional<std::string> append_row(const PlyElement& element, std::string_view line,
                                               std::vector<std::byte>& keep) {
    for (const PlyProperty& property : element.properties) {
      const std::string_view word = take_word(line);
      if (word.empty()) return fmt::format("has no value for {}", quoted(property.name));
      if (property.list_count) {
        const auto n = parse_integer(word);
        if (!n || *n < 0) return fmt::format("{} is no length of a list", quoted(word));
        for (std::int64_t i = 0; i < *n; ++i) {
          if (take_word(line).empty()) return fmt::format("list {} is cut", quoted(property.name));
        }
        continue;
      }
      const std::size_t at = keep.size();
      keep.resize(at + field_bytes(property.type));
      if (!store_ascii_value(word, property.type, keep.data() + at)) {
        return fmt::format("{} is no value for {}", quoted(word), quoted(property.name));
      }
    }
    if (!trimmed(line).empty()) return std::string("has more values than properties");
    return std::nullopt;
  }

  std::string_view rest_;
  std::size_t line_;  ///< number of the last line read
  bool ends_whole_;
  const std::string& path_;
};

template <class Rows>
Status read_vertices(const PlyHeader& header, std::size_t vertex, Rows rows,
                     std::vector<std::byte>& data) {
  for (std::size_t i = 0; i <= vertex; ++i) {
    if (auto status = rows.read(header.elements[i], i == vertex ? &data : nullptr); !status) {
      return status;
    }
  }
  return {};
}

Result<CloudFile> cloud_of(const PlyElement& vertex, const std::string& path) {
  CloudFile cloud;
  cloud.kind = CloudFileKind::kPly;
  std::uint32_t offset = 0;
  for (const PlyProperty& property : vertex.properties) {
    if (property.list_count) continue;
    cloud.fields.push_back({field_name(property.name), offset, property.type, 1});
    offset += field_bytes(property.type);
  }
  if (offset == 0) return fail(ErrorCode::kInput, path, "its vertices have no properties");
  if (vertex.count > kCloudBytesMax / offset) {
    return fail(ErrorCode::kInput, path,
                fmt::format("{} vertices of {} bytes are more than 4 GiB", vertex.count, offset));
  }
  cloud.width = static_cast<std::uint32_t>(vertex.count);
  cloud.point_step = offset;
  return cloud;
}

}  // namespace

Result<CloudFile> parse_ply(std::vector<std::byte> bytes, const std::string& path) {
  const auto header = parse_ply_header(bytes, path);
  if (!header) return tl::make_unexpected(header.error());
  const auto& elements = header->elements;
  const auto found = std::find_if(elements.begin(), elements.end(),
                                  [](const PlyElement& e) { return e.name == "vertex"; });
  if (found == elements.end()) return fail(ErrorCode::kInput, path, "has no element vertex");
  auto cloud = cloud_of(*found, path);
  if (!cloud) return cloud;
  const auto vertex = static_cast<std::size_t>(found - elements.begin());
  const auto body = std::span<const std::byte>(bytes).subspan(header->data_offset);
  Status status;
  if (header->encoding == PlyEncoding::kAscii) {
    cloud->encoding = "ascii";
    status = read_vertices(*header, vertex, AsciiRows(as_text(body), header->data_line, path),
                           cloud->data);
  } else {
    const bool big = header->encoding == PlyEncoding::kBinaryBig;
    cloud->encoding = big ? "binary_big_endian" : "binary_little_endian";
    status = read_vertices(*header, vertex, BinaryRows(body, big, path), cloud->data);
  }
  if (!status) return tl::make_unexpected(status.error());
  return cloud;
}

}  // namespace rali::io
