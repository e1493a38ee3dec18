#include "rali/config/codecs.hpp"

#include <filesystem>

#include <fmt/format.h>

namespace rali::config {

tl::unexpected<Error> not_allowed(const Node& node, const std::string& key,
                                  const std::string& type) {
  return fail(ErrorCode::kUsage, node.where,
              fmt::format("{} {}; allowed is {}", key, describe_value(node), type));
}

std::string encode_list(std::span<const double> values) {
  std::string text = "[";
  for (const double value : values) text += (text.size() > 1 ? ", " : "") + yaml_number(value);
  return text + "]";
}

CustomTarget number_or(std::optional<double>& value, std::string_view word, double min,
                       double max) {
  CustomTarget target;
  target.type = fmt::format("{}, or {} to {}", word, yaml_number(min), yaml_number(max));
  target.decode = [&value, word = std::string(word), min, max, type = target.type](
                      const Node& node, const std::string& key) -> Status {
    double number = 0.0;
    if (node.kind == Node::Kind::kScalar && node.text == word) {
      value.reset();
      return {};
    }
    const bool is_number =
        node.kind == Node::Kind::kScalar && !node.quoted && parse_double(node.text, number);
    if (!is_number || !(number >= min && number <= max)) return not_allowed(node, key, type);
    value = number;
    return {};
  };
  target.encode = [&value, word = std::string(word)] { return value ? yaml_number(*value) : word; };
  return target;
}

CustomTarget box_or_none(std::optional<std::array<double, 6>>& box) {
  CustomTarget target;
  target.type = "none, or [xmin,xmax,ymin,ymax,zmin,zmax]";
  target.decode = [&box, type = target.type](const Node& node, const std::string& key) -> Status {
    if (node.kind == Node::Kind::kScalar && node.text == "none") {
      box.reset();
      return {};
    }
    std::array<double, 6> values{};
    if (node.kind != Node::Kind::kSequence) return not_allowed(node, key, type);
    const Field field{key, std::span<double>(values), -100.0, 100.0, ""};
    if (Status status = decode_field(field, node); !status) return status;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (values[2 * axis] < values[2 * axis + 1]) continue;
      return fail(ErrorCode::kUsage, node.where,
                  fmt::format("{}: {}min is not below {}max", key, "xyz"[axis], "xyz"[axis]));
    }
    box = values;
    return {};
  };
  target.encode = [&box] { return box ? encode_list(*box) : std::string("none"); };
  return target;
}

std::string resolve_path(const std::string& path, const std::string& base_dir) {
  if (base_dir.empty() || path.empty()) return path;
  const std::filesystem::path given(path);
  if (given.is_absolute()) return path;
  return (std::filesystem::path(base_dir) / given).lexically_normal().string();
}

std::string relative_path(const std::string& path, const std::string& base_dir) {
  if (base_dir.empty() || path.empty()) return path;
  std::error_code error;
  const auto absolute = std::filesystem::absolute(path, error);
  const auto base = std::filesystem::absolute(base_dir, error);
  if (error) return path;
  const auto relative = absolute.lexically_normal().lexically_relative(base.lexically_normal());
  return relative.empty() ? path : relative.string();
}

CustomTarget path_or_none(std::string& path, const std::string& base_dir) {
  CustomTarget target;
  target.type = "none, or a file";
  target.decode = [&path, base_dir, type = target.type](const Node& node,
                                                        const std::string& key) -> Status {
    if (node.kind != Node::Kind::kScalar || node.text.empty()) return not_allowed(node, key, type);
    path = node.text == "none" && !node.quoted ? std::string() : resolve_path(node.text, base_dir);
    return {};
  };
  target.encode = [&path, base_dir] {
    if (path.empty()) return std::string("none");
    const std::string relative = relative_path(path, base_dir);
    return relative == "none" ? std::string("\"none\"") : yaml_quoted(relative);
  };
  return target;
}

CustomTarget text_or_none(std::string& text) {
  CustomTarget target;
  target.type = "none, or a word";
  target.decode = [&text, type = target.type](const Node& node, const std::string& key) -> Status {
    if (node.kind != Node::Kind::kScalar || node.text.empty()) return not_allowed(node, key, type);
    text = node.text == "none" && !node.quoted ? std::string() : node.text;
    return {};
  };
  target.encode = [&text] {
    if (text.empty()) return std::string("none");
    return text == "none" ? std::string("\"none\"") : yaml_quoted(text);
  };
  return target;
}

CustomTarget path_list(std::vector<std::string>& paths, const std::string& base_dir) {
  CustomTarget target;
  target.type = "a recording, or a list of recordings";
  target.decode = [&paths, base_dir, type = target.type](const Node& node,
                                                         const std::string& key) -> Status {
    std::vector<std::string> read;
    const auto add = [&](const Node& item) {
      if (item.kind != Node::Kind::kScalar || item.text.empty()) return false;
      read.push_back(resolve_path(item.text, base_dir));
      return true;
    };
    if (node.kind == Node::Kind::kSequence) {
      for (const Node& item : node.children) {
        if (!add(item)) return not_allowed(item, key, type);
      }
    } else if (!add(node)) {
      return not_allowed(node, key, type);
    }
    if (read.empty()) return not_allowed(node, key, type);
    paths = std::move(read);
    return {};
  };
  target.encode = [&paths, base_dir] {
    if (paths.size() == 1) return yaml_quoted(relative_path(paths.front(), base_dir));
    std::string text = "[";
    for (const std::string& path : paths) {
      text += (text.size() > 1 ? ", " : "") + yaml_quoted(relative_path(path, base_dir));
    }
    return text + "]";
  };
  return target;
}

CustomTarget known_word(std::string& value, std::string type,
                        std::function<bool(const std::string&)> is_known) {
  CustomTarget target;
  target.type = std::move(type);
  target.decode = [&value, is_known = std::move(is_known), text = target.type](
                      const Node& node, const std::string& key) -> Status {
    if (node.kind != Node::Kind::kScalar || !is_known(node.text)) {
      return not_allowed(node, key, text);
    }
    value = node.text;
    return {};
  };
  target.encode = [&value] { return yaml_quoted(value); };
  return target;
}

}  // namespace rali::config
