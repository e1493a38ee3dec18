#pragma once

#include <functional>
#include <memory>
#include <string>

#include "rali/drive/input/message_order.hpp"
#include "rali/io/message_source.hpp"

namespace rali::drive {

using KeepTopic = std::function<bool(const io::Topic&)>;

/// Copies the messages of a recording to a temporary file and hands them out sorted: memory grows
/// by 56 bytes a message, the disk by the messages. Equal times keep the order of the file.
/// Messages without a header of their own (kHeader) stay behind the one before them; /tf_static
/// comes first. Sorted by header, the record times are the headers' too.
/// @param source with its topics selected
/// @param order kRecordTime or kHeader
/// Errors: kMachine (no room).
[[nodiscard]] Result<std::unique_ptr<io::MessageSource>> sort_messages(
    std::unique_ptr<io::MessageSource> source, const std::string& name, MessageOrder order);

/// A recording, and how its messages come.
struct OrderedRecording {
  std::unique_ptr<io::MessageSource> source;
  MessageOrder order = MessageOrder::kFile;
};

/// Opens a recording so that its messages come in order of time, as far as it tells one. What its
/// index and its first seconds show to be in order is read as it lies. Else all stamps are read
/// first (32 bytes each), and what is out of order is sorted. That it was is a finding (D19) in
/// health().
/// @param most_s so much of the data is wanted [s]; 0: all. No more stamps are read.
/// Errors: as io::open_recording; kMachine.
[[nodiscard]] Result<OrderedRecording> open_in_order(const std::string& path, const KeepTopic& keep,
                                                     double most_s = 0.0);

}  // namespace rali::drive
