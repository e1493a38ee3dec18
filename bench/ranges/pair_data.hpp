#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/geometry/types.hpp"

namespace rali::ranges_bench {

/// One range and what it should have been.
struct PairRange {
  Time t;
  double range_m = 0.0;
  double true_m = 0.0;
  geometry::Vec3 sight = geometry::Vec3::UnitX();  ///< unit vector between the two ends
  double rssi_dbm = 0.0;                           ///< 0: not known
  double first_path_dbm = 0.0;
};

/// Ranges of one pair of antennas, in time.
struct PairRecord {
  std::vector<PairRange> ranges;
  bool at_rest = false;  ///< neither end moves
};

struct PairSet {
  std::string name;
  std::vector<PairRecord> pairs;
};

/// The sets of the folder uwb_pairs (its README says what they are): outdoor_static (a place is a
/// pair, with and without line of sight apart), outdoor_dynamic (one file each), moving_robots (all
/// trials together, each pair of robots in one direction: the other one is the same exchange), and
/// three_tags. Errors: a file that is missing or has not the columns.
[[nodiscard]] Result<std::vector<PairSet>> read_pair_sets(const std::filesystem::path& folder);

}  // namespace rali::ranges_bench
