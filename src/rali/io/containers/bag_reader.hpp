#pragma once

#include <memory>

#include "rali/io/containers/byte_source.hpp"
#include "rali/io/containers/reader_state.hpp"
#include "rali/io/message_source.hpp"

namespace rali::io {

/// Reads a ROS 1 bag 2.0 chunk by chunk in the order of the file. The index gives counts and time
/// span if present; it is never required. Errors: not a bag 2.0, encrypted, disk.
[[nodiscard]] Result<std::unique_ptr<MessageSource>> open_bag(std::shared_ptr<ByteSource> source,
                                                              const ReadLimits& limits = {});

}  // namespace rali::io
