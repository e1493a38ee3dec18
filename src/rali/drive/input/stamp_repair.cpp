#include "rali/drive/input/stamp_repair.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace rali::drive {
namespace {

/// A step that differs from the other clock's by more is a jump: recorders lag by tenths of a
/// second, clocks that are set jump by seconds and more.
constexpr double kJumpS = 1.0;
/// A stamp below this was never set: no recording was made in the first seconds of 1970, and boot
/// clocks have run for longer when a sensor is up.
constexpr double kZeroS = 1e-3;
constexpr double kShiftAgreeS = 0.5;

bool stands_still(std::span<const StampPair> pairs, Time StampPair::*clock) {
  return pairs.size() >= 3 && std::all_of(pairs.begin(), pairs.end(), [&](const StampPair& p) {
           return p.*clock == pairs.front().*clock;
         });
}

Duration step(Time from, Time to) {
  // Corrupt stamps span the whole int64: the difference is taken in unsigned arithmetic.
  const auto diff = static_cast<std::int64_t>(static_cast<std::uint64_t>(to.ns) -
                                              static_cast<std::uint64_t>(from.ns));
  return {diff};
}

}  // namespace

StampDecision decide_stamps(std::span<const StampPair> first) {
  if (first.empty()) return {};
  const bool record_still = stands_still(first, &StampPair::record);
  const auto zeros = std::count_if(first.begin(), first.end(), [](const StampPair& p) {
    return std::abs(p.header.s()) < kZeroS;
  });
  const auto n = static_cast<std::ptrdiff_t>(first.size());
  // A single first stamp of zero is a driver starting up (rslidar_sdk#179), not a zero header
  // clock.
  if (zeros > 0 && 2 * zeros >= n) return {StampRule::kRecord, "header stamps are zero"};
  if (record_still) return {};
  if (stands_still(first, &StampPair::header)) {
    return {StampRule::kRecord, "header stamps never change"};
  }
  std::ptrdiff_t jumps = 0;
  for (std::size_t i = 1; i < first.size(); ++i) {
    const Duration by_header = step(first[i - 1].header, first[i].header);
    const Duration by_record = step(first[i - 1].record, first[i].record);
    if (std::abs(by_header.s() - by_record.s()) > kJumpS) ++jumps;
  }
  if (n >= 5 && 5 * jumps > n) {
    return {StampRule::kRecord, "header stamps jump against the record time"};
  }
  return {};
}

std::optional<double> clock_offset_s(std::span<const StampPair> pairs) {
  if (pairs.empty()) return std::nullopt;
  std::vector<double> offsets;
  offsets.reserve(pairs.size());
  for (const StampPair& p : pairs) offsets.push_back(step(p.record, p.header).s());
  const auto middle = offsets.begin() + static_cast<std::ptrdiff_t>(offsets.size() / 2);
  std::nth_element(offsets.begin(), middle, offsets.end());
  return *middle;
}

Duration ClockShifts::agree(Duration shift, std::size_t* used) {
  for (std::size_t i = *used; i < shifts_.size(); ++i) {
    if (std::abs(shifts_[i].s() - shift.s()) < kShiftAgreeS) {
      *used = i + 1;
      return shifts_[i];
    }
  }
  shifts_.push_back(shift);
  *used = shifts_.size();
  return shift;
}

StampRepair::StampRepair(StampRule rule, std::shared_ptr<ClockShifts> shifts)
    : rule_(rule), shifts_(std::move(shifts)) {}

void StampRepair::start_file(bool clock_was_set) {
  file_begins_ = true;
  clock_was_set_ = clock_was_set;
}

void StampRepair::close_jumps(StampPair stamps) {
  const Duration by_header = step(last_.header, stamps.header);
  const Duration by_record = step(last_.record, stamps.record);
  const bool clocks_differ = std::abs(by_header.s() - by_record.s()) > kJumpS;
  const bool goes_back = by_header.s() <= -kJumpS;
  if (!clocks_differ && !goes_back) return;  // steady, or a pause in both
  // Only a recorder whose clock continued proves that a clock was set. Otherwise the message is out
  // of order, and its stamp is right.
  if (goes_back && by_record.ns <= 0 && !clock_was_set_ && !file_begins_) return;
  const bool record_usable = by_record.ns > 0 && by_record.s() < 60.0;
  const bool header_plausible = by_header.s() > -kJumpS && by_header.s() < 60.0;
  const bool header_regular = by_header.s() > -kJumpS && by_header.s() < kJumpS;

  Duration wanted = by_header;
  if (!header_plausible) {
    wanted = record_usable ? by_record : period_;
  } else if (clocks_differ && !header_regular && record_usable) {
    // The header advanced by seconds while the recorder did not: its clock was set.
    wanted = by_record;
  }
  if (wanted == by_header) return;
  const Duration jump{static_cast<std::int64_t>(static_cast<std::uint64_t>(wanted.ns) -
                                                static_cast<std::uint64_t>(by_header.ns))};
  const Duration agreed = shifts_->agree(jump, &shifts_used_);
  shift_ = Duration{static_cast<std::int64_t>(static_cast<std::uint64_t>(shift_.ns) +
                                              static_cast<std::uint64_t>(agreed.ns))};
  last_jump_s_ = -jump.s();
  ++jumps_;
}

std::optional<Time> StampRepair::repair(StampPair stamps) {
  if (rule_ == StampRule::kRecord) stamps.header = stamps.record;
  // A stamp that was never set (drivers send it once at the start) is useless.
  if (std::abs(stamps.header.s()) < kZeroS) {
    ++repeats_;
    return std::nullopt;
  }
  if (!started_) {
    started_ = true;
    last_ = stamps;
    last_out_ = stamps.header;
    file_begins_ = false;
    return stamps.header;
  }
  if (stamps.header == last_.header && !file_begins_) {
    ++repeats_;
    last_.record = stamps.record;
    return std::nullopt;
  }
  const Duration by_header = step(last_.header, stamps.header);
  // A pause between two files is no jump, however long: only a step back is.
  if (!file_begins_ || by_header.ns <= 0) close_jumps(stamps);
  file_begins_ = false;
  last_ = stamps;
  const Time out{static_cast<std::int64_t>(static_cast<std::uint64_t>(stamps.header.ns) +
                                           static_cast<std::uint64_t>(shift_.ns))};
  const Duration moved = step(last_out_, out);
  if (moved.ns > 0 && moved.s() < kJumpS) {
    period_ = Duration{period_.ns == 0 ? moved.ns : (7 * period_.ns + moved.ns) / 8};
  }
  last_out_ = out;
  return out;
}

}  // namespace rali::drive
