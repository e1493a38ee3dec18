#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/geometry/types.hpp"

namespace rali::ranges_bench {

/// One range and its true value.
struct PairRange {
  Time t;
  double range_m = 0.0;
  double true_m = 0.0;
  geometry::Vec3 sight = geometry::Vec3::UnitX();  ///< unit vector between the two ends
  double rssi_dbm = 0.0;                           ///< 0: unknown
  double first_path_dbm = 0.0;
};

/// Ranges of one pair of antennas, in the order of time.
struct PairRecord {
  std::vector<PairRange> ranges;
  bool at_rest = false;  ///< neither end moves
};

struct PairSet {
  std::string name;
  std::vector<PairRecord> pairs;
};

/// The sets of the folder uwb_pairs (described in its README): outdoor_static (each position is a
/// pair, line of sight and NLOS separate), outdoor_dynamic (one set per file), moving_robots (all
/// trials together, each pair of robots in one direction: the other one is the same exchange), and
/// three_tags. Errors: a missing file or one without the columns.
[[nodiscard]] Result<std::vector<PairSet>> read_pair_sets(const std::filesystem::path& folder);

}  // namespace rali::ranges_bench
