#include "rali/io/files/ply_header.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include <fmt/core.h>

#include "rali/io/files/cloud_file.hpp"
#include "rali/io/files/input_file.hpp"
#include "rali/io/files/text.hpp"

namespace rali::io {
namespace {

constexpr std::size_t kLinesMax = 10000;  // some programs write long comments
constexpr std::size_t kPropertiesMax = 1000;

constexpr std::array<std::pair<std::string_view, wire::FieldType>, 16> kTypes = {{
    {"char", wire::FieldType::kInt8},
    {"uchar", wire::FieldType::kUint8},
    {"short", wire::FieldType::kInt16},
    {"ushort", wire::FieldType::kUint16},
    {"int", wire::FieldType::kInt32},
    {"uint", wire::FieldType::kUint32},
    {"float", wire::FieldType::kFloat32},
    {"double", wire::FieldType::kFloat64},
    {"int8", wire::FieldType::kInt8},
    {"uint8", wire::FieldType::kUint8},
    {"int16", wire::FieldType::kInt16},
    {"uint16", wire::FieldType::kUint16},
    {"int32", wire::FieldType::kInt32},
    {"uint32", wire::FieldType::kUint32},
    {"float32", wire::FieldType::kFloat32},
    {"float64", wire::FieldType::kFloat64},
}};

std::optional<wire::FieldType> type_named(std::string_view word) {
  for (const auto& [name, type] : kTypes) {
    if (name == word) return type;
  }
  return std::nullopt;
}

class HeaderReader {
 public:
  HeaderReader(std::span<const std::byte> bytes, const std::string& path)
      : text_(as_text(bytes)), path_(path) {}

  Result<PlyHeader> read() {
    std::string_view rest = text_;
    std::string_view line;
    while (line_ < kLinesMax && take_line(rest, line)) {
      ++line_;
      if (line_ == 1) continue;  // "ply", checked by the caller
      if (trimmed(line) == "end_header") {
        if (!format_seen_) return error("the header has no format line");
        header_.data_offset = text_.size() - rest.size();
        header_.data_line = line_ + 1;
        return std::move(header_);
      }
      if (auto status = take(line); !status) return tl::make_unexpected(status.error());
    }
    return fail(ErrorCode::kInput, path_, "the PLY header has no end_header");
  }

 private:
  Status take(std::string_view line) {
    const std::string_view key = take_word(line);
    if (key.empty() || key == "comment" || key == "obj_info") return {};
    if (key == "format") return take_format(line);
    if (key == "element") return take_element(line);
    if (key == "property") return take_property(line);
    return error(fmt::format("{} is no keyword of a PLY header", quoted(key)));
  }

  Status take_format(std::string_view line) {
    const std::string_view word = take_word(line);
    if (word == "ascii") {
      header_.encoding = PlyEncoding::kAscii;
    } else if (word == "binary_little_endian") {
      header_.encoding = PlyEncoding::kBinaryLittle;
    } else if (word == "binary_big_endian") {
      header_.encoding = PlyEncoding::kBinaryBig;
    } else {
      return error(fmt::format("format {} is not known", quoted(word)));
    }
    format_seen_ = true;
    return {};
  }

  Status take_element(std::string_view line) {
    PlyElement element;
    element.name = std::string(take_word(line));
    const std::string_view word = take_word(line);
    const auto count = parse_integer(word);
    if (element.name.empty() || !count || *count < 0) {
      return error(
          fmt::format("element {} has no number but {}", quoted(element.name), quoted(word)));
    }
    element.count = static_cast<std::uint64_t>(*count);
    header_.elements.push_back(std::move(element));
    return {};
  }

  Status take_property(std::string_view line) {
    if (header_.elements.empty()) return error("a property stands before the first element");
    PlyProperty property;
    std::string_view word = take_word(line);
    if (word == "list") {
      const std::string_view length = take_word(line);
      const auto type = type_named(length);
      const bool real = type == wire::FieldType::kFloat32 || type == wire::FieldType::kFloat64;
      if (!type || real) {
        return error(fmt::format("{} is no type for the length of a list", quoted(length)));
      }
      property.list_count = type;
      word = take_word(line);
    }
    const auto type = type_named(word);
    if (!type) return error(fmt::format("{} is no type of PLY", quoted(word)));
    property.type = *type;
    property.name = std::string(take_word(line));
    if (property.name.empty()) return error("a property has no name");
    if (++properties_ > kPropertiesMax) return error("the header has more than 1000 properties");
    header_.elements.back().properties.push_back(std::move(property));
    return {};
  }

  tl::unexpected<Error> error(std::string what) const {
    return fail(ErrorCode::kInput, fmt::format("{}:{}", path_, line_), std::move(what));
  }

  std::string_view text_;
  const std::string& path_;
  std::size_t line_ = 0;
  std::size_t properties_ = 0;
  bool format_seen_ = false;
  PlyHeader header_;
};

}  // namespace

bool PlyElement::has_lists() const {
  return std::any_of(properties.begin(), properties.end(),
                     [](const PlyProperty& p) { return p.list_count.has_value(); });
}

std::uint64_t PlyElement::fixed_bytes() const {
  std::uint64_t bytes = 0;
  for (const PlyProperty& property : properties) {
    if (!property.list_count) bytes += field_bytes(property.type);
  }
  return bytes;
}

std::uint64_t PlyElement::bytes_min() const {
  std::uint64_t bytes = fixed_bytes();
  for (const PlyProperty& property : properties) {
    if (property.list_count) bytes += field_bytes(*property.list_count);
  }
  return bytes;
}

Result<PlyHeader> parse_ply_header(std::span<const std::byte> bytes, const std::string& path) {
  return HeaderReader(bytes, path).read();
}

}  // namespace rali::io
