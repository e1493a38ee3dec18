#include "rali/config/apply.hpp"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "rali/config/foreign_names.hpp"
#include "rali/config/suggest.hpp"

namespace rali::config {
namespace {

constexpr std::string_view kCommandLine = "command line";

bool begins_with(std::string_view text, std::string_view start) {
  return text.substr(0, start.size()) == start;
}

bool is_group(const FieldList& fields, const std::string& prefix) {
  return std::any_of(fields.begin(), fields.end(),
                     [&](const Field& field) { return begins_with(field.key, prefix); });
}

/// The allowed names directly below `prefix`.
std::vector<std::string> names_below(const FieldList& fields, std::string_view prefix) {
  std::set<std::string> names;
  for (const Field& field : fields) {
    if (!begins_with(field.key, prefix)) continue;
    const std::string rest = field.key.substr(prefix.size());
    names.insert(rest.substr(0, rest.find('.')));
  }
  return {names.begin(), names.end()};
}

/// A key that exists in another group: its full name if its last part equals or resembles the word.
std::string elsewhere(const FieldList& fields, std::string_view word, std::string_view prefix) {
  const std::string room{prefix.substr(0, prefix.find('.') + 1)};
  std::vector<std::string> leaves, keys;
  for (const Field& field : fields) {
    if (!begins_with(field.key, room)) continue;
    leaves.push_back(field.key.substr(field.key.rfind('.') + 1));
    keys.push_back(field.key);
  }
  const std::string leaf = nearest_name(word, leaves);
  if (leaf.empty()) return {};
  return keys[static_cast<std::size_t>(std::find(leaves.begin(), leaves.end(), leaf) -
                                       leaves.begin())];
}

tl::unexpected<Error> unknown_key(const Node& child, const std::string& prefix,
                                  const FieldList& fields) {
  const std::string named = child.key_where == kCommandLine ? prefix + child.key : child.key;
  const std::string what = fmt::format("unknown key '{}'", named.substr(0, 80));
  const std::string foreign = foreign_name_remedy(child.key);
  if (!foreign.empty()) return fail(ErrorCode::kUsage, child.key_where, what, foreign);
  const std::vector<std::string> here = names_below(fields, prefix);
  if (nearest_name(child.key, here).empty()) {
    const std::string other = elsewhere(fields, child.key, prefix);
    if (!other.empty()) {
      return fail(ErrorCode::kUsage, child.key_where, what,
                  fmt::format("Did you mean '{}'?", other));
    }
  }
  return fail(ErrorCode::kUsage, child.key_where, what, suggestion(child.key, here));
}

}  // namespace

Status apply_map(const Node& map, const std::string& prefix, const std::string& origin,
                 const FieldList& fields, Origins& origins) {
  if (map.kind == Node::Kind::kNull) return {};
  if (map.kind != Node::Kind::kMap) {
    const std::string name = prefix.empty() ? "the file" : prefix.substr(0, prefix.size() - 1);
    return fail(ErrorCode::kUsage, map.where, fmt::format("{} must be a group of keys", name),
                suggestion("", names_below(fields, prefix)));
  }
  for (const Node& child : map.children) {
    const std::string key = prefix + child.key;
    const auto field =
        std::find_if(fields.begin(), fields.end(), [&](const Field& f) { return f.key == key; });
    if (field != fields.end()) {
      if (Status status = decode_field(*field, child); !status) return status;
      origins[key] = origin.empty() ? child.where : origin;
    } else if (is_group(fields, key + '.')) {
      if (Status status = apply_map(child, key + '.', origin, fields, origins); !status) {
        return status;
      }
    } else {
      return unknown_key(child, prefix, fields);
    }
  }
  return {};
}

Result<Node> parse_assignment(std::string_view assignment) {
  const std::string where(kCommandLine);
  const std::size_t equals = assignment.find('=');
  if (equals == std::string_view::npos || equals == 0) {
    return fail(ErrorCode::kUsage, where,
                fmt::format("--set {} is not KEY=VALUE", assignment.substr(0, 80)),
                "Write for instance --set output.map_voxel_m=0.1.");
  }
  Result<Node> value = parse_yaml(assignment.substr(equals + 1), where);
  if (!value) return value;
  Node node = std::move(*value);
  std::vector<Node*> waiting{&node};
  while (!waiting.empty()) {
    Node* next = waiting.back();
    waiting.pop_back();
    next->where = where;
    if (!next->key.empty()) next->key_where = where;
    for (Node& child : next->children) waiting.push_back(&child);
  }
  std::string_view path = assignment.substr(0, equals);
  int depth = 0;
  while (true) {
    const std::size_t dot = path.rfind('.');
    node.key = std::string(dot == std::string_view::npos ? path : path.substr(dot + 1));
    node.key_where = where;
    if (node.key.empty() || ++depth > kMaxYamlDepth) {
      return fail(
          ErrorCode::kUsage, where,
          fmt::format("'{}' is no key", assignment.substr(0, std::min(equals, std::size_t{80}))));
    }
    Node parent;
    parent.kind = Node::Kind::kMap;
    parent.where = where;
    parent.children.push_back(std::move(node));
    node = std::move(parent);
    if (dot == std::string_view::npos) return node;
    path = path.substr(0, dot);
  }
}

}  // namespace rali::config
