#pragma once

#include <string>
#include <vector>

#include "join.hpp"

namespace rali::fleet_bench {

struct Arguments {
  std::vector<std::string> scenes = {"corridor", "floor"};  ///< as Place has them
  std::vector<std::uint64_t> seeds = {401, 402, 403, 404, 405};
  std::vector<JoinOptions> rows;
  Place place;                        ///< scene and seed are replaced
  std::vector<std::string> settings;  ///< key=value for the centre
  bool mesh = false;
  bool per_round = false;
  bool per_run = false;
  std::string cache_dir, dump_dir;
  std::string into;                ///< FILE:NAME, the tables go there as well
  std::vector<std::string> words;  ///< as given
  bool help = false;
};

/// Errors (kUsage): unknown options, scenes, rows or numbers.
[[nodiscard]] Result<Arguments> parse_arguments(int argc, const char* const* argv);

[[nodiscard]] std::string help_text();

}  // namespace rali::fleet_bench
