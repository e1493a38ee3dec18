#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rali/base/time.hpp"

namespace rali::drive {

/// Header and record time of one message.
struct StampPair {
  Time header, record;
};

enum class StampRule { kHeader, kRecord };

/// Which of the two clocks of a topic is reliable, and why.
struct StampDecision {
  StampRule rule = StampRule::kHeader;
  std::string reason;  ///< empty if the headers are fine
};

/// Decides from a topic's first messages. Headers that are zero, constant or jump against the
/// record time are rejected; if the record times are constant (converted files), the headers are
/// used.
[[nodiscard]] StampDecision decide_stamps(std::span<const StampPair> first);

/// Median of header - record [s]; empty without messages. Two topics whose medians differ by more
/// than kClockSplitS do not share a clock.
[[nodiscard]] std::optional<double> clock_offset_s(std::span<const StampPair> pairs);
inline constexpr double kClockSplitS = 2.0;

/// Clock jumps closed so far, shared by the topics of a vehicle: they run on one clock, so a jump
/// closed in one topic must be closed by the same amount in the others.
class ClockShifts {
 public:
  /// The shift to use where a topic measured `shift`: a known one within 0.5 s that the topic has
  /// not used yet (`*used` is its count), else a new one.
  [[nodiscard]] Duration agree(Duration shift, std::size_t* used);

 private:
  std::vector<Duration> shifts_;
};

/// Makes one topic's stamps usable: closes clock jumps, drops repeats. Stamps only slightly out of
/// order pass (the ordering window sorts them).
class StampRepair {
 public:
  StampRepair(StampRule rule, std::shared_ptr<ClockShifts> shifts);

  /// The stamp to use; empty: a repeat or a zero stamp, to be dropped.
  [[nodiscard]] std::optional<Time> repair(StampPair stamps);

  /// A new file begins: its first stamps need not follow the last ones smoothly.
  /// @param clock_was_set true: where header and record time go back together, the computer's clock
  /// was set; false: such a message is out of order and keeps its stamp
  void start_file(bool clock_was_set = false);

  [[nodiscard]] std::uint64_t jumps() const { return jumps_; }

  [[nodiscard]] std::uint64_t repeats() const { return repeats_; }

  /// Size of the last jump closed [s].
  [[nodiscard]] double last_jump_s() const { return last_jump_s_; }

 private:
  void close_jumps(StampPair stamps);

  StampRule rule_;
  std::shared_ptr<ClockShifts> shifts_;
  std::size_t shifts_used_ = 0;
  bool started_ = false;
  bool file_begins_ = false;
  bool clock_was_set_ = false;
  StampPair last_;
  Time last_out_;
  Duration shift_;   ///< added to the headers
  Duration period_;  ///< typical step between messages, smoothed
  std::uint64_t jumps_ = 0, repeats_ = 0;
  double last_jump_s_ = 0.0;
};

}  // namespace rali::drive
