#pragma once

#include <functional>
#include <memory>
#include <string>

#include "rali/drive/input/message_order.hpp"
#include "rali/io/message_source.hpp"

namespace rali::drive {

using KeepTopic = std::function<bool(const io::Topic&)>;

/// Copies the messages of a recording to a temporary file and returns them sorted: memory grows by
/// 56 bytes per message, the disk by the messages. Equal times keep the order of the file. Messages
/// without a header of their own (kHeader) stay behind the preceding one; /tf_static comes first.
/// If sorted by header, the headers replace the record times.
/// @param source with its topics selected
/// @param order kRecordTime or kHeader
/// Errors: kMachine (no disk space).
[[nodiscard]] Result<std::unique_ptr<io::MessageSource>> sort_messages(
    std::unique_ptr<io::MessageSource> source, const std::string& name, MessageOrder order);

/// A recording, and the order of its messages.
struct OrderedRecording {
  std::unique_ptr<io::MessageSource> source;
  MessageOrder order = MessageOrder::kFile;
};

/// Opens a recording so that its messages come in time order, as far as it can be determined. If
/// the index and the first seconds are in order, the file is read as it is. Else all stamps are
/// read first (32 bytes each), and messages out of order are sorted. Sorting is reported as a
/// finding (D19) in health().
/// @param max_s length of the requested data [s]; 0: all. No more stamps are read.
/// Errors: as io::open_recording; kMachine.
[[nodiscard]] Result<OrderedRecording> open_in_order(const std::string& path, const KeepTopic& keep,
                                                     double max_s = 0.0);

}  // namespace rali::drive
