#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rali/base/result.hpp"

namespace rali::config {

/// A parsed YAML value. Plain data, so that yaml-cpp stays in one .cpp.
struct Node {
  enum class Kind { kNull, kScalar, kSequence, kMap };
  Kind kind = Kind::kNull;
  std::string key;        ///< name within the parent map; empty elsewhere
  std::string key_where;  ///< position of the key, "fleet.yaml:14"
  std::string where;      ///< position of the value, "fleet.yaml:14" or "command line"
  std::string text;       ///< of a scalar
  bool quoted = false;    ///< a scalar in quotes is text, never a number
  std::vector<Node> children;

  /// The child with this key; nullptr if there is none or this is no map.
  [[nodiscard]] const Node* find(std::string_view name) const;
};

/// Limits for a settings file, against hostile files.
inline constexpr std::size_t kMaxYamlBytes = 1U << 20U;
inline constexpr std::size_t kMaxYamlNodes = 20000;  // an alias counts as all nodes it stands for
inline constexpr int kMaxYamlDepth = 32;

/// Parses one YAML document; an empty text is an empty map.
/// Errors (kUsage, where = name:line): syntax, a key given twice, two documents, a key that is no
/// plain text, more than the bounds above.
[[nodiscard]] Result<Node> parse_yaml(std::string_view text, std::string_view name);

/// Reads and parses a file; `name` in messages is `path` as given.
/// Errors: kUsage as above; kInput if it cannot be read.
[[nodiscard]] Result<Node> parse_yaml_file(const std::string& path);

/// `text` as a YAML scalar that reads back as this text: quoted where needed.
[[nodiscard]] std::string yaml_quoted(std::string_view text);

/// The shortest decimal that reads back as the same double; `.inf`, `-.inf`, `.nan`.
[[nodiscard]] std::string yaml_number(double value);

/// Locale-free numbers of the whole text; false if it is anything else.
[[nodiscard]] bool parse_double(std::string_view text, double& value);
[[nodiscard]] bool parse_integer(std::string_view text, long long& value);

}  // namespace rali::config
