#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "rali/base/finding.hpp"
#include "rali/drive/input/stamp_repair.hpp"

namespace rali::inspect {

/// Statistics of the stamps of one topic, in the order of the file.
struct StampStatistics {
  std::uint64_t messages = 0;
  double period_s = 0.0;      ///< median step of the headers; of the record times if headers are
                              ///< unusable
  double span_s = 0.0;        ///< last minus first
  std::uint64_t missing = 0;  ///< messages absent by the period; jitter is no loss
  double longest_gap_s = 0.0;
  Time t_longest_gap;
  std::uint64_t repeated = 0;  ///< same stamp as the one before
  std::uint64_t backward = 0;  ///< older than the one before
  std::uint64_t zero = 0;
  std::uint64_t jumps = 0;      ///< steps above 0.8 s that are not in the record time
  double batch_fraction = 0.0;  ///< messages that arrived within a tenth of a period of the last
  double clock_offset_s = 0.0;  ///< median of header - record
  double delay_jitter_s = 0.0;  ///< 95 % - 5 % of header - record
  drive::StampDecision decision;

  [[nodiscard]] double rate_hz() const { return period_s > 0.0 ? 1.0 / period_s : 0.0; }

  /// Fraction of the expected messages.
  [[nodiscard]] double missing_fraction() const;
};

[[nodiscard]] StampStatistics study_stamps(std::span<const drive::StampPair> stamps);

/// D01 (scans) or D10 (inertial samples): rate and gaps. At least one finding: the rate.
void report_rate(const StampStatistics& s, const std::string& id, const std::string& what,
                 const std::string& topic, FindingList& out);

/// D04: zero, repeated, backward, jumping stamps, another clock than the recorder's.
void report_stamps(const StampStatistics& s, const std::string& topic, FindingList& out);

/// D04: two topics that do not share a clock.
void report_clock_split(const StampStatistics& lidar, const StampStatistics& imu,
                        const std::string& imu_topic, FindingList& out);

}  // namespace rali::inspect
