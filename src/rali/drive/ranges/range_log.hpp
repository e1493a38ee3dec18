#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/ranging/range_use.hpp"

namespace rali::drive {

/// Statistics of the ranges of one pair of vehicles. NaN: not known.
struct RangePair {
  std::string name;  ///< "v1-v2"
  std::size_t total = 0, used = 0;
  double bias_m = std::numeric_limits<double>::quiet_NaN();          ///< as last estimated
  double residual_std_m = std::numeric_limits<double>::quiet_NaN();  ///< of those used
};

/// Statistics of the ranges of a run.
struct RangeTally {
  std::size_t total = 0;
  Time first, last;  ///< stamps of the earliest and of the latest
  std::array<std::size_t, ranging::kRangeReasonNames.size()> by_reason{};
  std::vector<RangePair> pairs;  ///< of vehicles of the fleet, by their order

  [[nodiscard]] std::size_t used() const { return by_reason[0]; }

  /// The most frequent reason for rejection; kUsed if none was rejected.
  [[nodiscard]] ranging::RangeReason commonest_refusal() const;
};

/// Every range of a run, once, with its result. 112 bytes per range.
class RangeLog {
 public:
  /// @param vehicles names by number
  explicit RangeLog(std::vector<std::string> vehicles) : vehicles_(std::move(vehicles)) {}

  /// Names of ends that are no vehicle, for the table.
  void name_strangers(std::map<std::uint16_t, std::string> names) { strangers_ = std::move(names); }

  /// A range that is passed to its vehicles, in time order.
  void add_handed(const sensor::RangeSample& sample);

  /// A range that is passed to no vehicle, and why.
  void add_refused(const sensor::RangeSample& sample, ranging::RangeReason reason);

  /// How a vehicle used a range. If both ends report, the one that used it counts, else the one
  /// that moved. Reports about ranges that were not passed on are ignored.
  void answer(const ranging::RangeUse& use, VehicleId by, bool moving);

  [[nodiscard]] bool empty() const { return handed_.empty() && refused_.empty(); }

  /// Every range, by time; valid until the next change.
  [[nodiscard]] std::vector<const ranging::RangeUse*> in_order() const;

  /// Errors: kMachine.
  [[nodiscard]] Status write(const std::string& path) const;

  [[nodiscard]] RangeTally tally() const;

 private:
  /// Rank of a report: none yet, by a standing vehicle, by a moving one, used.
  enum class Worth : std::uint8_t { kNone, kStanding, kMoving, kUsed };

  struct Row {
    ranging::RangeUse use;
    Worth worth = Worth::kNone;
    std::array<bool, 2> answered{};  ///< by from, by to
  };

  [[nodiscard]] std::string name_of(VehicleId id) const;

  std::vector<std::string> vehicles_;
  std::map<std::uint16_t, std::string> strangers_;
  std::vector<Row> handed_;  ///< by time
  std::vector<ranging::RangeUse> refused_;
};

}  // namespace rali::drive
