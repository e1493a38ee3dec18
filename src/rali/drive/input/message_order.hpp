#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "rali/drive/input/stamp_repair.hpp"

namespace rali::drive {

/// Order in which the messages of a recording have to be read.
enum class MessageOrder {
  kFile,        ///< as they lie in the file
  kClockSet,    ///< the same; where header and record time go back, the computer's clock was set
  kRecordTime,  ///< the file is out of order of time: sorted by record time
  kHeader,  ///< the record times tell nothing and the headers are out of order: sorted by header
};

/// One message of a topic that the vehicle needs, in the order of the file.
struct TopicStamp {
  std::size_t topic = 0;
  bool cloud = false;
  StampPair stamp;
};

/// Stamps that are more than half a second older than the newest one before them: too late for the
/// ordering window.
[[nodiscard]] std::size_t late_stamps(std::span<const StampPair> stamps, Time StampPair::*clock);

/// Tells a file whose messages are out of order from one whose clock was set back. A clock that is
/// set back passes through times that were recorded already, or leaves a gap; messages that are
/// out of order fill each other's gaps once they are sorted.
/// @param stamps all messages of one topic
[[nodiscard]] MessageOrder decide_message_order(std::span<const StampPair> stamps);

/// The same for all topics of a file together: clouds decide before inertial data. Topics that are
/// in order each but not with each other (a file written topic by topic) are sorted.
[[nodiscard]] MessageOrder decide_message_order(std::span<const TopicStamp> stamps);

}  // namespace rali::drive
