#pragma once

#include <string>
#include <vector>

#include "rali/base/result.hpp"

namespace rali::ranges_bench {

struct Arguments {
  std::string data_dir;            ///< holds uwb_pairs and range_slam
  bool pairs = true, slam = true;  ///< which parts
  std::string only;                ///< tracks and sets with this in their name; empty: all
  std::string into;                ///< FILE:NAME, the tables go there as well
  std::vector<std::string> words;  ///< as given
  bool help = false;
};

/// Errors (kUsage): an unknown option, a value that is missing.
[[nodiscard]] Result<Arguments> parse_arguments(int argc, const char* const* argv);

[[nodiscard]] std::string help_text();

}  // namespace rali::ranges_bench
