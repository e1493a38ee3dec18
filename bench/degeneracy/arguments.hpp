#pragma once

#include <string>
#include <vector>

#include "rali/odometry/robust/settings.hpp"
#include "rali/sim/simulation.hpp"

namespace rali::degeneracy_bench {

struct Arguments {
  std::vector<std::string> places;
  std::vector<std::uint64_t> seeds = {1, 2, 3};
  std::vector<sim::Lidar> lidars = {sim::Lidar::kRs16, sim::Lidar::kHdl32e, sim::Lidar::kOs1_64};
  int pedestrians = 4;
  double distance_m = 60.0;
  bool others = true;  ///< tunnels again with another vehicle in view
  odometry::RobustSettings robust;
  std::string json;                ///< file
  std::string into;                ///< FILE:NAME
  std::vector<std::string> words;  ///< command line as given
};

/// @return the arguments, or the exit code with which the program ends: 0 after --help, 2 if they
/// are wrong (a sentence on stderr).
[[nodiscard]] tl::expected<Arguments, int> parse_arguments(int argc, const char* const* argv);

}  // namespace rali::degeneracy_bench
