#include "rali/config/text_of.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace rali::config {
namespace {

constexpr std::size_t kCommentColumn = 44;

std::vector<std::string> split_key(const std::string& key) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t dot = key.find('.'); dot != std::string::npos; dot = key.find('.', begin)) {
    parts.push_back(key.substr(begin, dot - begin));
    begin = dot + 1;
  }
  parts.push_back(key.substr(begin));
  return parts;
}

/// A comment must stay on one line, whatever a file name contains.
std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return text;
}

std::string cell(std::string text) {
  for (std::size_t at = text.find('|'); at != std::string::npos; at = text.find('|', at + 2)) {
    text.insert(at, "\\");
  }
  return text;
}

}  // namespace

std::string dump_yaml(const FieldList& fields, const Origins& origins) {
  std::string text;
  std::vector<std::string> open;
  for (const Field& field : fields) {
    const std::vector<std::string> parts = split_key(field.key);
    std::size_t common = 0;
    while (common < open.size() && common + 1 < parts.size() && open[common] == parts[common]) {
      ++common;
    }
    open.resize(common);
    for (; common + 1 < parts.size(); ++common) {
      text += fmt::format("{:{}}{}:\n", "", 2 * common, parts[common]);
      open.push_back(parts[common]);
    }
    const std::string line =
        fmt::format("{:{}}{}: {}", "", 2 * common, parts.back(), encode_field(field));
    const auto origin = origins.find(field.key);
    text += fmt::format("{:<{}}  # {}\n", line, kCommentColumn,
                        origin == origins.end() ? "default" : one_line(origin->second));
  }
  return text;
}

std::uint64_t hash_fields(const FieldList& fields) {
  std::uint64_t hash = 14695981039346656037ULL;
  const auto add = [&hash](std::string_view text) {
    for (const char c : text) {
      hash ^= static_cast<unsigned char>(c);
      hash *= 1099511628211ULL;
    }
  };
  for (const Field& field : fields) {
    add(field.key);
    add("=");
    add(encode_field(field));
    add("\n");
  }
  return hash;
}

std::string manual_table(const FieldList& fields) {
  if (fields.empty()) return {};
  std::string text = "| key | default | allowed | meaning |\n|---|---|---|---|\n";
  for (const Field& field : fields) {
    text += fmt::format("| `{}` | `{}` | {} | {} |\n", field.key, cell(encode_field(field)),
                        cell(allowed_text(field)), cell(field.help));
  }
  return text;
}

}  // namespace rali::config
