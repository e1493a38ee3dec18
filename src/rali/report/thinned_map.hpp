#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "rali/base/result.hpp"
#include "rali/report/run_data.hpp"

namespace rali::report {

/// Number of map points kept: more than any drawing shows (51 MB).
inline constexpr std::size_t kMapPointsMax = 3'000'000;

struct ThinnedMap {
  MapPoints points;
  std::uint64_t points_in_file = 0;
  std::string note;  ///< the missing part; empty: the file is complete
};

/// Points of a PCD or PLY, thinned while they are read: memory does not grow with the file. A
/// point's selection depends only on its index in the file. A truncated binary file gives the
/// points it holds, and a note. Errors: kInput for files that are no cloud, and for text and
/// compressed files above 256 MiB, which cannot be read in parts.
[[nodiscard]] Result<ThinnedMap> read_thinned_map(const std::string& path,
                                                  std::size_t points_max = kMapPointsMax);

/// Well mixed bits of an index: the selection must not follow the order in the file.
/// Source: S. Vigna, splitmix64 (public domain).
[[nodiscard]] std::uint64_t mixed(std::uint64_t x);

}  // namespace rali::report
