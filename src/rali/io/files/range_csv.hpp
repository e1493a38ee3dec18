#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/ids.hpp"
#include "rali/base/result.hpp"
#include "rali/sensor/range_sample.hpp"

namespace rali::io {

/// One end of a radio link: which antenna of which vehicle.
struct RadioEnd {
  VehicleId vehicle;
  std::uint8_t antenna = 0;
  constexpr auto operator<=>(const RadioEnd&) const = default;
};

/// Names of radios in CSV files: "v1", and "v1/uwb" for a named antenna.
using RadioNames = std::map<std::string, RadioEnd, std::less<>>;

/// Rows that could not be used.
struct RadioCsvStats {
  struct Unknown {
    std::uint64_t rows = 0;
    std::uint64_t first_line = 0;
  };

  std::uint64_t rows = 0;
  std::uint64_t unknown_rows = 0;  ///< an end is not in the list of names
  std::uint64_t bad_rows = 0;      ///< a required cell is no finite number, or cells are missing
  std::uint64_t self_rows = 0;     ///< both ends on one vehicle
  std::uint64_t first_bad_line = 0;
  std::string first_bad_reason;
  std::map<std::string, Unknown, std::less<>> unknown;  ///< per name, at most 100 names
};

struct RangeCsv {
  std::vector<sensor::RangeSample> samples;  ///< in the order of the file
  RadioCsvStats stats;
  FindingList findings;
};

struct RadioCsv {
  std::vector<sensor::RadioSample> samples;
  RadioCsvStats stats;
  FindingList findings;
};

/// Reads `stamp_s,from,to,range_m[,rssi_dbm,first_path_dbm,from_antenna,to_antenna,sigma_m]`
/// (product.md section 7). An antenna is an index, or a name: "uwb" of "v1" is looked up as
/// "v1/uwb". Range limits are not applied here. Errors: kInput (unreadable, a column missing, no
/// row that fits).
[[nodiscard]] Result<RangeCsv> read_ranges_csv(const std::string& path, const RadioNames& names);
[[nodiscard]] Result<RangeCsv> parse_ranges_csv(std::string text, const std::string& name,
                                                const RadioNames& names);

/// Reads `stamp_s,from,to,rssi_dbm`.
[[nodiscard]] Result<RadioCsv> read_radio_csv(const std::string& path, const RadioNames& names);
[[nodiscard]] Result<RadioCsv> parse_radio_csv(std::string text, const std::string& name,
                                               const RadioNames& names);

}  // namespace rali::io
