#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/wire/encoding.hpp"

namespace rali::io {

struct Topic {
  std::string name;
  std::string type;  ///< as in the file, e.g. "sensor_msgs/PointCloud2" or ".../msg/..."
  wire::Encoding encoding = wire::Encoding::kOther;
  std::string encoding_name;              ///< as in the file
  std::string definition;                 ///< message definition text if the file has it
  std::optional<std::uint64_t> messages;  ///< count, if there is an index
};

/// One message as stored in the file. `data` stays valid until the next call of next().
struct RawMessage {
  std::size_t topic = 0;  ///< index in MessageSource::topics()
  Time t_record;          ///< when the recorder received it
  std::span<const std::byte> data;
  std::uint64_t offset = 0;  ///< byte offset (or row id) for error messages
};

/// Losses of a container; grows while reading.
struct SourceHealth {
  std::uint64_t messages = 0;          ///< handed out
  std::uint64_t messages_skipped = 0;  ///< damaged: not decodable, CRC wrong, ...
  std::uint64_t bytes_lost = 0;        ///< after the last whole record of a truncated file
  bool truncated = false;
  bool unindexed = false;
  std::string compression;  ///< "none", "lz4", "bz2", "zstd", "mixed"
  FindingList findings;     ///< one sentence each, with file and offset
};

/// A container of messages (ROS 1 bag, MCAP, rosbag2) read as a stream in the order of the file.
/// Memory does not grow with the file. Topics may be added while reading; indices never change.
class MessageSource {
 public:
  virtual ~MessageSource() = default;

  [[nodiscard]] virtual const std::vector<Topic>& topics() const = 0;

  /// Only messages of topics for which keep(topic) is true are returned (and, where possible,
  /// read at all). Call before the first next(); the default keeps all.
  virtual void select(std::function<bool(const Topic&)> keep) = 0;

  /// True: `out` holds the next message. False: end. An Error only if reading cannot continue
  /// (local damage is skipped and counted in health()).
  [[nodiscard]] virtual Result<bool> next(RawMessage& out) = 0;

  [[nodiscard]] virtual const SourceHealth& health() const = 0;

  /// Fraction of the file read so far, 0 to 1.
  [[nodiscard]] virtual double progress() const = 0;

  /// First and last record time if an index or summary contains them.
  [[nodiscard]] virtual std::optional<std::pair<Time, Time>> span() const = 0;

  /// Whether the parts of the file are in order of record time, within kOrderSlackS; empty without
  /// an index.
  [[nodiscard]] virtual std::optional<bool> in_order() const = 0;
};

/// Parts of a file (chunks, splits) that overlap by up to this time still count as in order [s].
inline constexpr double kOrderSlackS = 0.5;

/// Opens a recording of any kind by its content (never by its extension alone): ROS 1 bag, MCAP,
/// rosbag2 folder, .db3, .db3.zstd. Other files are rejected with a sentence that names their kind
/// ("raw network packets (pcap)", "a point cloud (PLY)", "empty file").
[[nodiscard]] Result<std::unique_ptr<MessageSource>> open_recording(const std::string& path);

}  // namespace rali::io
