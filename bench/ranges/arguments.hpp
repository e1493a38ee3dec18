#pragma once

#include <string>
#include <vector>

#include "rali/base/result.hpp"

namespace rali::ranges_bench {

struct Arguments {
  std::string data_dir;            ///< contains uwb_pairs and range_slam
  bool pairs = true, slam = true;  ///< which parts
  std::string only;                ///< tracks and sets with this in their name; empty: all
  std::string into;                ///< FILE:NAME, the tables are also written there
  std::vector<std::string> words;  ///< command line as given
};

/// @return the arguments, or the exit code with which the program ends: 0 after --help, 2 if they
/// are wrong (a sentence on stderr).
[[nodiscard]] tl::expected<Arguments, int> parse_arguments(int argc, const char* const* argv);

}  // namespace rali::ranges_bench
