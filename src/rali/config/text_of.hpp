#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rali/config/field.hpp"

namespace rali::config {

/// The fields as nested YAML, each value with its origin as a comment. Valid input again.
[[nodiscard]] std::string dump_yaml(const FieldList& fields, const Origins& origins);

/// FNV-1a over keys and values, in the order of the list: equal settings have equal hashes. Origins
/// are not hashed.
[[nodiscard]] std::uint64_t hash_fields(const FieldList& fields);

/// A Markdown table: key, default, allowed values, meaning.
[[nodiscard]] std::string manual_table(const FieldList& fields);

}  // namespace rali::config
