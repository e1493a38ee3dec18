#pragma once

#include <string>
#include <vector>

#include "suites.hpp"

namespace rali::tunnel {

struct Arguments {
  Suite suite;
  std::vector<std::uint64_t> seeds = {101, 102, 103, 104};
  std::vector<std::string> settings;  ///< key=value for the vehicle, of all rows
  sim::Lidar lidar = sim::Lidar::kRs16;
  double duration_s = 0.0;
  std::string cache_dir, dump_dir, json;
  std::string into;                ///< FILE:NAME, the tables are also written there
  std::vector<std::string> words;  ///< command line as given
};

/// @return the arguments, or the exit code with which the program ends: 0 after --help, 2 if they
/// are wrong (a sentence on stderr).
[[nodiscard]] tl::expected<Arguments, int> parse_arguments(int argc, const char* const* argv);

}  // namespace rali::tunnel
