#include "rali/drive/input/message_order.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "rali/io/message_source.hpp"

namespace rali::drive {
namespace {

using Clock = Time StampPair::*;

/// Fraction of the late messages that step back once more. In a stretch that is late as a whole (a
/// clock that was set, a block at the wrong place) hardly any message does.
constexpr double kScatteredFraction = 0.2;
/// Fraction of the late messages with a neighbour nearer than half a period: their time was
/// recorded twice.
constexpr double kTwiceFraction = 0.25;
/// Headers override the record times only if they are regular when sorted.
constexpr double kIrregularFraction = 0.1;
/// Limit for stamps that were never set, as in decide_stamps.
constexpr double kZeroS = 1e-3;

/// Statistics of one clock's stamps in the order of the file and sorted.
struct ClockOrder {
  std::size_t late = 0;       ///< too late for the ordering window
  std::size_t scattered = 0;  ///< those of them that step back from the previous message
  std::size_t blocks = 0;     ///< steps back by more than the window
  std::size_t twice = 0;      ///< sorted steps below half a period
  std::size_t gaps = 0;       ///< sorted steps of more than two periods and the window
  double span_s = 0.0;
};

double period_of(std::vector<double> steps_s) {
  std::erase_if(steps_s, [](double step_s) { return !(step_s > 0.0); });
  if (steps_s.empty()) return 0.0;
  const auto middle = steps_s.begin() + static_cast<std::ptrdiff_t>(steps_s.size() / 2);
  std::nth_element(steps_s.begin(), middle, steps_s.end());
  return *middle;
}

void study_sorted(std::vector<double> times_s, ClockOrder& order) {
  std::sort(times_s.begin(), times_s.end());
  order.span_s = times_s.back() - times_s.front();
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < times_s.size(); ++i) steps_s.push_back(times_s[i] - times_s[i - 1]);
  const double period_s = period_of(steps_s);
  for (const double step_s : steps_s) {
    if (step_s < 0.5 * period_s) ++order.twice;
    if (step_s > std::max(2.0 * period_s, io::kOrderSlackS)) ++order.gaps;
  }
}

/// Times as doubles: differences of hostile stamps do not overflow, and 1 us is fine enough here.
ClockOrder study(std::span<const StampPair> stamps, Clock clock) {
  ClockOrder order;
  if (stamps.empty()) return order;
  std::vector<double> times_s;
  times_s.reserve(stamps.size());
  double newest_s = -std::numeric_limits<double>::infinity();
  for (const StampPair& pair : stamps) {
    const double t_s = (pair.*clock).s();
    if (newest_s - t_s > io::kOrderSlackS) {
      ++order.late;
      if (t_s < times_s.back()) ++order.scattered;
      if (times_s.back() - t_s > io::kOrderSlackS) ++order.blocks;
    }
    newest_s = std::max(newest_s, t_s);
    times_s.push_back(t_s);
  }
  study_sorted(std::move(times_s), order);
  return order;
}

/// @return kFile (in order), kClockSet, or kRecordTime for "out of order"
MessageOrder judge(const ClockOrder& order) {
  if (order.late == 0) return MessageOrder::kFile;
  const auto late = static_cast<double>(order.late);
  if (static_cast<double>(order.scattered) > kScatteredFraction * late && order.scattered > 1) {
    return MessageOrder::kRecordTime;
  }
  if (static_cast<double>(order.twice) > kTwiceFraction * late) return MessageOrder::kClockSet;
  return order.gaps >= order.blocks ? MessageOrder::kClockSet : MessageOrder::kRecordTime;
}

/// Never set, or set once: such a clock does not define the order.
bool is_useless(std::span<const StampPair> stamps, Clock clock) {
  const Time first = stamps.front().*clock;
  std::size_t zeros = 0;
  bool still = stamps.size() > 1;
  for (const StampPair& pair : stamps) {
    zeros += std::abs((pair.*clock).s()) < kZeroS ? 1 : 0;
    still = still && pair.*clock == first;
  }
  return still || 2 * zeros >= stamps.size();
}

/// Stamps that jump back and forth without a clock are not regular when sorted, and do not span the
/// time that the recorder ran.
bool is_regular(const ClockOrder& header, const ClockOrder& record, std::size_t messages,
                bool record_useless) {
  const auto n = static_cast<double>(messages);
  const bool even = static_cast<double>(header.twice + header.gaps) < kIrregularFraction * n;
  const double tolerance_s = 1.0 + 0.2 * record.span_s;
  return even && (record_useless || std::abs(header.span_s - record.span_s) < tolerance_s);
}

}  // namespace

std::size_t late_stamps(std::span<const StampPair> stamps, Time StampPair::*clock) {
  double newest_s = -std::numeric_limits<double>::infinity();
  std::size_t late = 0;
  for (const StampPair& pair : stamps) {
    const double t_s = (pair.*clock).s();
    if (newest_s - t_s > io::kOrderSlackS) ++late;
    newest_s = std::max(newest_s, t_s);
  }
  return late;
}

MessageOrder decide_message_order(std::span<const StampPair> stamps) {
  if (stamps.size() < 3) return MessageOrder::kFile;
  const bool header_useless = is_useless(stamps, &StampPair::header);
  const ClockOrder header = study(stamps, &StampPair::header);
  if (!header_useless && header.late == 0) return MessageOrder::kFile;
  const bool record_useless = is_useless(stamps, &StampPair::record);
  const ClockOrder record = study(stamps, &StampPair::record);
  if (!record_useless && record.late > 0) return judge(record);
  if (header_useless) return MessageOrder::kFile;
  const MessageOrder by_header = judge(header);
  if (by_header == MessageOrder::kClockSet) {
    // If the recorder's clock continued, the stream itself shows the jump.
    return record_useless ? MessageOrder::kClockSet : MessageOrder::kFile;
  }
  return is_regular(header, record, stamps.size(), record_useless) ? MessageOrder::kHeader
                                                                   : MessageOrder::kFile;
}

MessageOrder decide_message_order(std::span<const TopicStamp> stamps) {
  std::map<std::size_t, std::vector<StampPair>> topics;
  std::map<std::size_t, bool> clouds;
  std::vector<StampPair> all;
  for (const TopicStamp& s : stamps) {
    topics[s.topic].push_back(s.stamp);
    clouds[s.topic] = s.cloud;
    all.push_back(s.stamp);
  }
  for (const bool cloud : {true, false}) {
    for (const auto& [topic, of_topic] : topics) {
      if (clouds[topic] != cloud) continue;
      const MessageOrder order = decide_message_order(of_topic);
      if (order != MessageOrder::kFile) return order;
    }
  }
  if (all.empty()) return MessageOrder::kFile;
  if (!is_useless(all, &StampPair::record)) {
    return late_stamps(all, &StampPair::record) > 0 ? MessageOrder::kRecordTime
                                                    : MessageOrder::kFile;
  }
  const bool mixed =
      !is_useless(all, &StampPair::header) && late_stamps(all, &StampPair::header) > 0;
  return mixed ? MessageOrder::kHeader : MessageOrder::kFile;
}

}  // namespace rali::drive
