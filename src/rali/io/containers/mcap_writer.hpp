#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/io/containers/byte_sink.hpp"
#include "rali/io/containers/codec.hpp"

namespace rali::io {

/// Writes an MCAP with checksums, indexes, statistics and summary; the same bytes for the same
/// calls. Only appends. Without close() the file is as a killed recorder leaves it.
class McapWriter {
 public:
  struct Options {
    std::string profile = "ros2";
    Compression compression = Compression::kZstd;  ///< none, lz4 or zstd
    std::size_t chunk_bytes = 1U << 20;            ///< 0: no chunks, and then no compression
  };

  McapWriter(ByteSink& sink, Options options) : sink_(sink), options_(std::move(options)) {}

  /// `encoding` of the definition text: "ros1msg", "ros2msg", "jsonschema". Returns what
  /// add_channel() takes.
  [[nodiscard]] Result<std::uint16_t> add_schema(const std::string& name,
                                                 const std::string& encoding,
                                                 const std::string& definition);

  /// `message_encoding`: "ros1", "cdr", "json". `schema` 0 means none.
  [[nodiscard]] Result<std::uint16_t> add_channel(
      std::uint16_t schema, const std::string& topic, const std::string& message_encoding,
      const std::map<std::string, std::string>& metadata = {});

  /// Errors: unknown channel, time before 1970, a chunk of 4 GiB or more, sink.
  [[nodiscard]] Status write(std::uint16_t channel, Time t_log, Time t_publish,
                             std::span<const std::byte> data);

  /// Writes the last chunk and the summary; nothing may be written afterwards.
  [[nodiscard]] Status close();

 private:
  struct Channel {
    std::vector<std::byte> record;
    std::uint16_t schema = 0;
    bool in_file = false;
    std::uint32_t sequence = 0;
    std::uint64_t messages = 0;
  };

  struct Schema {
    std::vector<std::byte> record;
    bool in_file = false;
  };

  struct ChunkIndex {
    std::uint64_t first_ns = 0;
    std::uint64_t last_ns = 0;
    std::uint64_t offset = 0;
    std::uint64_t bytes = 0;  ///< of the whole record
    std::map<std::uint16_t, std::uint64_t> index_offsets;
    std::uint64_t index_bytes = 0;
    std::uint64_t compressed_bytes = 0;
    std::uint64_t uncompressed_bytes = 0;
  };

  using IndexEntries = std::vector<std::pair<std::uint64_t, std::uint64_t>>;

  Status put(std::span<const std::byte> bytes);
  Status begin();
  void append_definitions(Channel& channel);
  Status flush_chunk();
  Status write_index(ChunkIndex& chunk);
  [[nodiscard]] std::vector<std::byte> statistics() const;
  Status write_summary();

  ByteSink& sink_;
  Options options_;
  std::uint64_t written_ = 0;
  bool closed_ = false;
  std::vector<Schema> schemas_;
  std::vector<Channel> channels_;
  std::vector<std::byte> chunk_;  ///< records not yet written
  std::uint64_t chunk_first_ns_ = 0;
  std::uint64_t chunk_last_ns_ = 0;
  std::map<std::uint16_t, IndexEntries> chunk_entries_;
  std::vector<ChunkIndex> chunks_;
  std::uint64_t messages_ = 0;
  std::uint64_t first_ns_ = 0;
  std::uint64_t last_ns_ = 0;
};

}  // namespace rali::io
