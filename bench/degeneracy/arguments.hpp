#pragma once

#include <string>
#include <vector>

#include "rali/odometry/robust/settings.hpp"
#include "rali/sim/simulation.hpp"

namespace rali::blindness {

struct Arguments {
  std::vector<std::string> places;
  std::vector<std::uint64_t> seeds = {1, 2, 3};
  std::vector<sim::Lidar> lidars = {sim::Lidar::kRs16, sim::Lidar::kHdl32e, sim::Lidar::kOs1_64};
  int pedestrians = 4;
  double way_m = 60.0;
  bool others = true;  ///< tunnels once more with another vehicle in view
  odometry::RobustSettings robust;
  std::string json;                ///< file
  std::string into;                ///< FILE:NAME
  std::vector<std::string> words;  ///< as given
  bool help = false;
};

[[nodiscard]] Result<Arguments> parse_arguments(int argc, const char* const* argv);

[[nodiscard]] std::string help_text();

}  // namespace rali::blindness
