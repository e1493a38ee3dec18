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

/// Appends one source's ranges, their stamps corrected for latency and clock.
void append(const RangeOptions& options, VehicleId clock, std::span<const double> clock_offsets_s,
            const std::vector<sensor::RangeSample>& samples, RangeList& list) {
  Duration shift = -options.latency();
  if (clock.value < clock_offsets_s.size()) {
    shift = shift + Duration::from_s(clock_offsets_s[clock.value]);
  }
  for (const sensor::RangeSample& sample : samples) {
    sensor::RangeSample& added = list.samples.emplace_back(sample);
    added.t = sample.t + shift;
    added.clock = clock;
  }
}

}  // namespace

Result<RangeList> read_range_files(const RangeOptions& options,
                                   std::span<const double> clock_offsets_s) {
  RangeList list;
  Strangers strangers(options.names);
  for (const RangeFile& file : options.files) {
    Result<io::RangeCsv> csv = io::read_ranges_csv(file.path, options.names);
    if (!csv) return tl::make_unexpected(csv.error());
    list.findings.insert(list.findings.end(), csv->findings.begin(), csv->findings.end());
    if (!csv->stats.unknown.empty()) {
      // Read again with their names: unusable ranges are reported row by row as well.
      for (const auto& [name, seen] : csv->stats.unknown) strangers.add(name);
      csv = io::read_ranges_csv(file.path, strangers.names());
      if (!csv) return tl::make_unexpected(csv.error());
    }
    append(options, file.clock, clock_offsets_s, csv->samples, list);
  }
  for (const SerialLog& log : options.serial_logs) {
    Result<SerialRanges> ranges = read_serial_log(log, options);
    if (!ranges) return tl::make_unexpected(ranges.error());
    list.findings.insert(list.findings.end(), ranges->findings.begin(), ranges->findings.end());
    append(options, log.vehicle, clock_offsets_s, ranges->samples, list);
  }
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
