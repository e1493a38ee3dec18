#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "rali/io/containers/bag_format.hpp"
#include "rali/io/containers/byte_source.hpp"
#include "rali/io/containers/reader_state.hpp"

namespace rali::io {

/// Index at the end of a closed bag.
struct BagIndex {
  std::vector<std::pair<std::uint32_t, Topic>> connections;
  std::map<std::uint32_t, std::uint64_t> counts;                ///< messages per connection
  std::vector<std::pair<std::uint64_t, std::uint64_t>> chunks;  ///< offset, messages; ascending
  std::optional<std::pair<Time, Time>> span;
  bool in_order = true;  ///< the chunks are in order of time
};

/// First record of a bag.
struct BagFileHeader {
  std::uint64_t index_offset = 0;  ///< 0: the recording was not closed
  std::uint32_t connections = 0;   ///< number of connections in the index
  std::uint32_t chunks = 0;
  std::uint64_t end = 0;  ///< offset of the next record
};

/// Checks the first line and reads the first record. Refuses older formats and encrypted bags. A
/// file cut within that record gives index_offset 0.
[[nodiscard]] Result<BagFileHeader> read_bag_file_header(ByteSource& source, ByteWindow& window);

/// The index from `offset` to the end of the file; none if it is inconsistent. It is optional:
/// messages are read without it.
[[nodiscard]] Result<std::optional<BagIndex>> read_bag_index(ByteSource& source, ByteWindow& window,
                                                             std::uint64_t offset,
                                                             const ReadLimits& limits);

/// Offset of the first plausible chunk record at or after `from`: where reading continues after
/// damage.
[[nodiscard]] Result<std::optional<std::uint64_t>> find_bag_chunk(ByteSource& source,
                                                                  ByteWindow& window,
                                                                  std::uint64_t from,
                                                                  DamageSearch& search);

}  // namespace rali::io
