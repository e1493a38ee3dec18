#pragma once

#include "rali/config/field.hpp"

namespace rali::config {

/// Stores the values of a YAML map in fields and records their origin. `prefix` ("" or ending with
/// a dot) is the key of the map. `origin` names the source of the values; empty: each value's own
/// file and line.
/// Errors (kUsage, where = file:line): unknown key with the nearest name, everything of
/// decode_field. Fields before the error are already changed.
[[nodiscard]] Status apply_map(const Node& map, const std::string& prefix,
                               const std::string& origin, const FieldList& fields,
                               Origins& origins);

/// Expands `a.b.c=value` to the map {a: {b: {c: value}}}; the value is YAML.
/// Errors (kUsage, where = "command line"): no '=', an empty name, a value that is not YAML.
[[nodiscard]] Result<Node> parse_assignment(std::string_view assignment);

}  // namespace rali::config
