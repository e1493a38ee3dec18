#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rali/io/containers/byte_source.hpp"
#include "rali/io/containers/mcap_format.hpp"
#include "rali/io/containers/reader_state.hpp"

namespace rali::io {

/// Summary at the end of a closed MCAP.
struct McapSummary {
  std::vector<McapSchema> schemas;
  std::vector<McapChannel> channels;
  std::optional<McapStatistics> statistics;
  std::vector<McapChunkIndex> chunks;

  /// Whether the chunks are in order of time; empty if not all of them are listed.
  [[nodiscard]] std::optional<bool> in_order() const;
};

/// The summary; none if it is missing, its CRC is wrong or it is inconsistent. `why` is then the
/// reason, for a message.
[[nodiscard]] Result<std::optional<McapSummary>> read_mcap_summary(ByteSource& source,
                                                                   ByteWindow& window,
                                                                   const ReadLimits& limits,
                                                                   std::string& why);

/// Compression of the first chunk, "none" if messages are outside chunks, empty if there is
/// neither. Determined before the first message is read.
[[nodiscard]] Result<std::string> first_mcap_compression(ByteSource& source, ByteWindow& window);

/// Offset of the first plausible chunk at or after `from`: its two lengths must agree.
[[nodiscard]] Result<std::optional<std::uint64_t>> find_mcap_chunk(ByteSource& source,
                                                                   ByteWindow& window,
                                                                   std::uint64_t from,
                                                                   DamageSearch& search);

/// Messages of a chunk as counted by the message indexes that start at `offset`, 0 if none.
[[nodiscard]] Result<std::uint64_t> count_mcap_index(ByteSource& source, ByteWindow& window,
                                                     std::uint64_t offset);

/// Offset after the closing magic of a file.
/// @param offset of the record that ends its data
/// @return nothing if the bytes in between are damaged or incomplete
[[nodiscard]] Result<std::optional<std::uint64_t>> end_of_mcap(ByteSource& source,
                                                               ByteWindow& window,
                                                               std::uint64_t offset);

}  // namespace rali::io
