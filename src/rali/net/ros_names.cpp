#include "rali/net/ros_names.hpp"

#include <cstddef>

namespace rali::net {
namespace {

constexpr std::size_t kNameMax = 200;  // rmw: 255 with prefix and suffix of services
constexpr std::string_view kTopicPrefix = "rt";
constexpr std::string_view kNamespace = "::msg::dds_::";
constexpr std::string_view kFolder = "/msg/";

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

bool is_word(std::string_view text) {
  if (text.empty() || (!is_letter(text[0]) && text[0] != '_')) return false;
  for (const char c : text) {
    if (!is_letter(c) && !(c >= '0' && c <= '9') && c != '_') return false;
  }
  return true;
}

/// "/a/b": words, each after a slash.
bool is_absolute_name(std::string_view name) {
  if (name.empty() || name.size() > kNameMax || name[0] != '/') return false;
  while (!name.empty()) {
    const std::size_t end = name.find('/', 1);
    if (!is_word(name.substr(1, end == std::string_view::npos ? end : end - 1))) return false;
    name = end == std::string_view::npos ? std::string_view{} : name.substr(end);
  }
  return true;
}

/// Splits a text into package and Name at `between`; both must be words.
bool split(std::string_view text, std::string_view between, std::string_view& package,
           std::string_view& name) {
  const std::size_t at = text.find(between);
  if (at == std::string_view::npos || text.size() > kNameMax) return false;
  package = text.substr(0, at);
  name = text.substr(at + between.size());
  return is_word(package) && is_word(name);
}

}  // namespace

std::optional<std::string> dds_topic_name(std::string_view ros_name) {
  if (!is_absolute_name(ros_name)) return std::nullopt;
  return std::string(kTopicPrefix) + std::string(ros_name);
}

std::optional<std::string> dds_type_name(std::string_view ros_type) {
  std::string_view package, name;
  if (!split(ros_type, kFolder, package, name)) return std::nullopt;
  return std::string(package) + std::string(kNamespace) + std::string(name) + "_";
}

std::optional<std::string> ros_topic_name(std::string_view dds_name) {
  if (!dds_name.starts_with(kTopicPrefix)) return std::nullopt;
  dds_name.remove_prefix(kTopicPrefix.size());
  if (!is_absolute_name(dds_name)) return std::nullopt;
  return std::string(dds_name);
}

std::optional<std::string> ros_type_name(std::string_view dds_type) {
  std::string_view package, name;
  if (!split(dds_type, kNamespace, package, name) || name.size() < 2 || !name.ends_with('_')) {
    return std::nullopt;
  }
  name.remove_suffix(1);
  return std::string(package) + std::string(kFolder) + std::string(name);
}

}  // namespace rali::net
