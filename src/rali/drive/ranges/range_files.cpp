#include "rali/drive/ranges/range_files.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "rali/drive/ranges/serial_log.hpp"

namespace rali::drive {
namespace {

bool is_antenna(VehicleId vehicle, std::uint8_t antenna, const RangeOptions& options) {
  return vehicle.value < options.antennas.size() && antenna < options.antennas[vehicle.value];
}

/// Numbers unknown names, each the same way in all files.
class Strangers {
 public:
  explicit Strangers(const io::RadioNames& names) : names_(names) {}

  void add(const std::string& name) {
    if (names_.contains(name)) return;
    const VehicleId id = unknown_name(count_++);
    names_[name] = {id, 0};
    by_number_[id.value] = name;
  }

  [[nodiscard]] const io::RadioNames& names() const { return names_; }

  [[nodiscard]] std::map<std::uint16_t, std::string> by_number() const { return by_number_; }

 private:
  io::RadioNames names_;
  std::map<std::uint16_t, std::string> by_number_;
  std::uint64_t count_ = 0;
};

}  // namespace

Result<RangeList> read_range_files(const RangeOptions& options) {
  RangeList list;
  Strangers strangers(options.names);
  for (const std::string& path : options.files) {
    Result<io::RangeCsv> csv = io::read_ranges_csv(path, options.names);
    if (!csv) return tl::make_unexpected(csv.error());
    list.findings.insert(list.findings.end(), csv->findings.begin(), csv->findings.end());
    if (!csv->stats.unknown.empty()) {
      // Read again with their names: unusable ranges are reported row by row as well.
      for (const auto& [name, seen] : csv->stats.unknown) strangers.add(name);
      csv = io::read_ranges_csv(path, strangers.names());
      if (!csv) return tl::make_unexpected(csv.error());
    }
    list.samples.insert(list.samples.end(), csv->samples.begin(), csv->samples.end());
  }
  for (const SerialLog& log : options.serial_logs) {
    Result<SerialRanges> ranges = read_serial_log(log, options);
    if (!ranges) return tl::make_unexpected(ranges.error());
    list.findings.insert(list.findings.end(), ranges->findings.begin(), ranges->findings.end());
    list.samples.insert(list.samples.end(), ranges->samples.begin(), ranges->samples.end());
  }
  const Duration latency = options.latency();
  for (sensor::RangeSample& sample : list.samples) sample.t = sample.t - latency;
  std::stable_sort(
      list.samples.begin(), list.samples.end(),
      [](const sensor::RangeSample& a, const sensor::RangeSample& b) { return a.t < b.t; });
  list.strangers = strangers.by_number();
  return list;
}

ranging::RangeReason judge_range(const sensor::RangeSample& sample, const RangeOptions& options) {
  const bool known = is_antenna(sample.from, sample.from_antenna, options) &&
                     is_antenna(sample.to, sample.to_antenna, options);
  if (!known) return ranging::RangeReason::kUnknownId;
  const bool possible = std::isfinite(sample.range_m) && sample.range_m >= options.limits_m[0] &&
                        sample.range_m <= options.limits_m[1];
  return possible ? ranging::RangeReason::kNoPose : ranging::RangeReason::kOutOfLimits;
}

}  // namespace rali::drive
