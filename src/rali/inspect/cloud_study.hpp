#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/sensor/lidar_scan.hpp"
#include "rali/wire/cloud_format.hpp"

namespace rali::inspect {

/// Statistics of the points of all scans.
class CloudStudy {
 public:
  /// @param points all points of the message, usable or not
  void add(const sensor::LidarScan& scan, std::size_t points);

  /// D01 points per scan, D02 and D03 as decided, D05 points without value, D06 rings.
  void report(const wire::CloudFormat& format, const std::string& topic, FindingList& out) const;

  [[nodiscard]] double points_per_scan() const;

  [[nodiscard]] std::uint64_t scans() const { return scans_; }

 private:
  struct Ring {
    std::uint64_t points = 0;
    double elevation_sum_rad = 0.0;
  };

  void add_rings(const sensor::LidarScan& scan);
  void report_nan_jumps(const std::string& topic, FindingList& out) const;
  void report_odd_times(const std::string& topic, FindingList& out) const;
  void report_times(const wire::CloudFormat& format, const std::string& topic,
                    FindingList& out) const;
  void report_rings(const wire::CloudFormat& format, const std::string& topic,
                    FindingList& out) const;

  std::uint64_t scans_ = 0, points_ = 0, usable_ = 0, nan_ = 0, out_of_range_ = 0, empty_ = 0;
  std::uint64_t untimed_scans_ = 0;
  std::uint64_t odd_time_scans_ = 0;  ///< all points at one time, or at invalid times
  std::vector<float> nan_fractions_;  ///< per scan
  double span_sum_s_ = 0.0;
  std::vector<Ring> rings_;
};

}  // namespace rali::inspect
