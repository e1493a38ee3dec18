#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rali/io/containers/byte_source.hpp"
#include "rali/io/containers/mcap_format.hpp"
#include "rali/io/containers/reader_state.hpp"

namespace rali::io {

/// What the end of a closed MCAP tells about the whole.
struct McapSummary {
  std::vector<McapSchema> schemas;
  std::vector<McapChannel> channels;
  std::optional<McapStatistics> statistics;
  std::vector<McapChunkIndex> chunks;

  /// Whether the chunks follow each other in time; empty if not all of them are listed.
  [[nodiscard]] std::optional<bool> in_order() const;
};

/// The summary; none if there is none, its CRC is wrong or anything in it does not add up. `why`
/// then says which, for a sentence.
[[nodiscard]] Result<std::optional<McapSummary>> read_mcap_summary(ByteSource& source,
                                                                   ByteWindow& window,
                                                                   const ReadLimits& limits,
                                                                   std::string& why);

/// Compression of the first chunk, "none" where messages lie outside chunks, empty if there is
/// neither: known before the first message is read.
[[nodiscard]] Result<std::string> first_mcap_compression(ByteSource& source, ByteWindow& window);

/// Offset of the first plausible chunk at or after `from`: its two lengths must agree.
[[nodiscard]] Result<std::optional<std::uint64_t>> find_mcap_chunk(ByteSource& source,
                                                                   ByteWindow& window,
                                                                   std::uint64_t from,
                                                                   DamageSearch& search);

/// Messages of a chunk as counted by the message indexes that start at `offset`, 0 if none.
[[nodiscard]] Result<std::uint64_t> count_mcap_index(ByteSource& source, ByteWindow& window,
                                                     std::uint64_t offset);

/// Offset behind the closing magic of a file.
/// @param offset of the record that ends its data
/// @return nothing if what lies between is damaged or ends before that
[[nodiscard]] Result<std::optional<std::uint64_t>> end_of_mcap(ByteSource& source,
                                                               ByteWindow& window,
                                                               std::uint64_t offset);

}  // namespace rali::io
