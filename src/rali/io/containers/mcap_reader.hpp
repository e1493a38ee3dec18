#pragma once

#include <memory>

#include "rali/io/containers/byte_source.hpp"
#include "rali/io/containers/reader_state.hpp"
#include "rali/io/message_source.hpp"

namespace rali::io {

/// Reads an MCAP in the order of the file, chunked or not. The summary gives topics, counts and
/// time span if present; it is never required. Errors: not MCAP, disk.
[[nodiscard]] Result<std::unique_ptr<MessageSource>> open_mcap(std::shared_ptr<ByteSource> source,
                                                               const ReadLimits& limits = {});

}  // namespace rali::io
