#pragma once

#include <string>
#include <vector>

#include "rali/sim/simulation.hpp"

namespace rali::accuracy {

struct Arguments {
  std::vector<sim::Scene> scenes;
  std::vector<std::uint64_t> seeds = {1, 2, 3};
  std::vector<std::string> presets = {"robust"};
  std::vector<std::string> settings;  ///< key=value for the vehicle
  sim::SimOptions sim;                ///< scene and seed are replaced
  std::string dump_dir, cache_dir;
  std::string into;                ///< FILE:NAME, the table is also written there
  std::vector<std::string> words;  ///< command line as given
  bool per_run = false;            ///< one row for each run, in addition to the summary
};

/// @return the arguments, or the exit code with which the program ends: 0 after --help, 2 if they
/// are wrong (a sentence on stderr).
[[nodiscard]] tl::expected<Arguments, int> parse_arguments(int argc, const char* const* argv);

}  // namespace rali::accuracy
