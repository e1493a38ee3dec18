#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "rali/drive/input/stamp_repair.hpp"

namespace rali::drive {

/// Order in which the messages of a recording must be read.
enum class MessageOrder {
  kFile,        ///< in the order of the file
  kClockSet,    ///< the same; where header and record time go back, the computer's clock was set
  kRecordTime,  ///< the file is out of time order: sorted by record time
  kHeader,      ///< record times are useless and headers out of order: sorted by header
};

/// One message of a topic that the vehicle needs, in the order of the file.
struct TopicStamp {
  std::size_t topic = 0;
  bool cloud = false;
  StampPair stamp;
};

/// Number of stamps more than half a second older than the newest one before them: too late for the
/// ordering window.
[[nodiscard]] std::size_t late_stamps(std::span<const StampPair> stamps, Time StampPair::*clock);

/// Distinguishes a file whose messages are out of order from one whose clock was set back. A clock
/// set back repeats times that are already recorded, or leaves a gap. Out-of-order messages fill
/// each other's gaps once they are sorted.
/// @param stamps all messages of one topic
[[nodiscard]] MessageOrder decide_message_order(std::span<const StampPair> stamps);

/// The same for all topics of a file together: clouds take precedence over inertial data. Topics
/// that are each in order but not with each other (a file written topic by topic) are sorted.
[[nodiscard]] MessageOrder decide_message_order(std::span<const TopicStamp> stamps);

}  // namespace rali::drive
