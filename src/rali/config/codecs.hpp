#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "rali/config/field.hpp"

namespace rali::config {

/// A word or a number: `word` stands for "not given" (auto, estimate).
[[nodiscard]] CustomTarget number_or(std::optional<double>& value, std::string_view word,
                                     double min, double max);

/// Six numbers or `none`.
[[nodiscard]] CustomTarget box_or_none(std::optional<std::array<double, 6>>& box);

/// A path or `none` (empty). Relative paths are read against `base_dir` and written relative to
/// it; with base_dir "" they stay as they are.
[[nodiscard]] CustomTarget path_or_none(std::string& path, const std::string& base_dir);

/// A word or `none` (empty).
[[nodiscard]] CustomTarget text_or_none(std::string& text);

/// One path or a list of paths, at least one.
[[nodiscard]] CustomTarget path_list(std::vector<std::string>& paths, const std::string& base_dir);

/// A word that `is_known` accepts; `type` says which these are.
[[nodiscard]] CustomTarget known_word(std::string& value, std::string type,
                                      std::function<bool(const std::string&)> is_known);

/// Converts `path`, as written in a file of folder `base_dir`, to a path that this process can
/// open.
[[nodiscard]] std::string resolve_path(const std::string& path, const std::string& base_dir);

/// The inverse: `path` as it must be written in a file of folder `base_dir`.
[[nodiscard]] std::string relative_path(const std::string& path, const std::string& base_dir);

/// The error "KEY is VALUE; allowed is TYPE".
[[nodiscard]] tl::unexpected<Error> not_allowed(const Node& node, const std::string& key,
                                                const std::string& type);

/// "[a, b]" of numbers.
[[nodiscard]] std::string encode_list(std::span<const double> values);

}  // namespace rali::config
