#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/base/rng.hpp"
#include "rali/config/yaml_tree.hpp"

namespace rali::campaign {

/// The generator's ranges (ranges.yaml). A missing key or one of another kind ends the program:
/// results of a campaign with other ranges than those of the file are meaningless.
class Ranges {
 public:
  /// Errors: of the file.
  [[nodiscard]] static Result<Ranges> load(const std::string& path);

  /// A number within `[a, b]` or `log [a, b]`. @param key e.g. "motion.speed_mps"
  [[nodiscard]] double number(std::string_view key, Rng& rng) const;

  /// The same, rounded to a whole number.
  [[nodiscard]] int count(std::string_view key, Rng& rng) const;

  /// True with the key's probability.
  [[nodiscard]] bool happens(std::string_view key, Rng& rng) const;

  /// One of the names of a map of weights.
  [[nodiscard]] std::string choice(std::string_view key, Rng& rng) const;

  /// FNV-1a of the file, to distinguish results with other ranges.
  [[nodiscard]] std::uint64_t hash() const { return hash_; }

 private:
  [[nodiscard]] const config::Node& at(std::string_view key) const;

  config::Node root_;
  std::uint64_t hash_ = 0;
};

}  // namespace rali::campaign
