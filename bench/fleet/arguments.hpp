#pragma once

#include <string>
#include <vector>

#include "join.hpp"

namespace rali::fleet_bench {

struct Arguments {
  std::vector<std::string> scenes = {"corridor", "floor"};  ///< as in Place
  std::vector<std::uint64_t> seeds = {401, 402, 403, 404, 405};
  std::vector<JoinOptions> rows;
  Place place;                        ///< scene and seed are replaced
  std::vector<std::string> settings;  ///< key=value for the fleet mapper
  bool mesh = false;
  bool per_round = false;
  bool per_run = false;
  std::string cache_dir, dump_dir;
  std::string into;                ///< FILE:NAME, the tables are also written there
  std::vector<std::string> words;  ///< command line as given
};

/// @return the arguments, or the exit code with which the program ends: 0 after --help, 2 if they
/// are wrong (a sentence on stderr).
[[nodiscard]] tl::expected<Arguments, int> parse_arguments(int argc, const char* const* argv);

}  // namespace rali::fleet_bench
