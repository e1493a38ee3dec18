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
};

/// @return the arguments, or the exit code with which the program ends: 0 after --help, 2 where
/// they
///         are wrong (a sentence on stderr).
[[nodiscard]] tl::expected<Arguments, int> parse_arguments(int argc, const char* const* argv);

}  // namespace rali::ranges_bench
