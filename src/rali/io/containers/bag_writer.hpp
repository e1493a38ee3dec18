#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/io/containers/byte_sink.hpp"
#include "rali/io/containers/codec.hpp"

namespace rali::io {

/// Writes a ROS 1 bag 2.0 with index, as rosbag does; the same bytes for the same calls. Without
/// close() the result is an unindexed bag, as after a killed recorder.
class BagWriter {
 public:
  struct Options {
    Compression compression = Compression::kLz4;  ///< none, lz4 or bz2
    std::size_t chunk_bytes = 768 * 1024;         ///< rosbag's default
  };

  BagWriter(ByteSink& sink, const Options& options) : sink_(sink), options_(options) {}

  /// Returns the number that write() takes. `md5sum` is ROS 1's checksum of the definition.
  [[nodiscard]] Result<std::uint32_t> add_connection(const std::string& topic,
                                                     const std::string& type,
                                                     const std::string& md5sum,
                                                     const std::string& definition);

  /// Times must lie between 1970 and 2106. Errors: unknown connection, time, size, sink.
  [[nodiscard]] Status write(std::uint32_t connection, Time t, std::span<const std::byte> data);

  /// Writes the last chunk and the index; nothing may be written afterwards.
  [[nodiscard]] Status close();

 private:
  struct Connection {
    std::vector<std::byte> record;
    bool in_file = false;
  };

  struct IndexEntry {
    Time t;
    std::uint32_t offset;
  };

  struct ChunkInfo {
    std::uint64_t offset;
    Time first;
    Time last;
    std::map<std::uint32_t, std::uint32_t> counts;
  };

  Status put(std::span<const std::byte> bytes);
  Status begin();
  Status flush_chunk();
  [[nodiscard]] std::vector<std::byte> file_header(std::uint64_t index_offset) const;

  ByteSink& sink_;
  Options options_;
  std::uint64_t written_ = 0;
  bool closed_ = false;
  std::vector<Connection> connections_;
  std::vector<std::byte> chunk_;
  std::map<std::uint32_t, std::vector<IndexEntry>> chunk_index_;
  std::vector<ChunkInfo> chunks_;
};

}  // namespace rali::io
