#include "rali/scenario/recording/container.hpp"

#include <algorithm>
#include <filesystem>
#include <limits>

#include "rali/io/containers/bag_writer.hpp"
#include "rali/io/containers/db3_writer.hpp"
#include "rali/io/containers/mcap_writer.hpp"
#include "rali/io/files/file_sink.hpp"
#include "rali/wire/definitions.hpp"

namespace rali::scenario {
namespace {

namespace fs = std::filesystem;

/// A file that can be truncated.
class CutSink final : public io::ByteSink {
 public:
  explicit CutSink(io::AtomicFile file) : file_(std::move(file)) {}

  Status write(std::span<const std::byte> bytes) override {
    const std::uint64_t room = limit_ - std::min(limit_, written_);
    written_ += bytes.size();
    return file_.write(bytes.first(std::min<std::uint64_t>(bytes.size(), room)));
  }

  Status overwrite(std::uint64_t offset, std::span<const std::byte> bytes) override {
    return file_.overwrite(offset, bytes);
  }

  /// Limits further output to so many bytes.
  void cut_after(std::uint64_t bytes) { limit_ = std::min(limit_, written_ + bytes); }

  [[nodiscard]] bool full() const { return written_ >= limit_; }

  [[nodiscard]] Status commit() { return file_.commit(); }

 private:
  io::FileSink file_;
  std::uint64_t written_ = 0;
  std::uint64_t limit_ = std::numeric_limits<std::uint64_t>::max();
};

/// Shorter than any chunk with a scan in it, so that the cut lies inside a record.
constexpr std::uint64_t kStump_bytes = 1000;

std::string ros2_name(const std::string& type) {
  const std::size_t slash = type.find('/');
  return type.substr(0, slash) + "/msg" + type.substr(slash);
}

class McapContainer final : public Container {
 public:
  explicit McapContainer(io::AtomicFile file) : sink_(std::move(file)), mcap_(sink_, {}) {}

  Result<std::size_t> add_topic(const std::string& topic, const std::string& type) override {
    const auto schema = mcap_.add_schema(ros2_name(type), "ros2msg",
                                         wire::message_definition(type, wire::Encoding::kCdr));
    if (!schema) return tl::make_unexpected(schema.error());
    const auto channel = mcap_.add_channel(*schema, topic, "cdr");
    if (!channel) return tl::make_unexpected(channel.error());
    return *channel;
  }

  Status write(std::size_t topic, Time t, std::span<const std::byte> data) override {
    if (sink_.full()) return {};
    return mcap_.write(static_cast<std::uint16_t>(topic), t, t, data);
  }

  void cut() override { sink_.cut_after(kStump_bytes); }

  Status close() override {
    if (Status s = mcap_.close(); !s) return s;
    return sink_.commit();
  }

  wire::Encoding encoding() const override { return wire::Encoding::kCdr; }

 private:
  CutSink sink_;
  io::McapWriter mcap_;
};

class BagContainer final : public Container {
 public:
  explicit BagContainer(io::AtomicFile file) : sink_(std::move(file)), bag_(sink_, {}) {}

  Result<std::size_t> add_topic(const std::string& topic, const std::string& type) override {
    const auto connection =
        bag_.add_connection(topic, type, std::string(wire::message_md5(type)),
                            wire::message_definition(type, wire::Encoding::kRos1));
    if (!connection) return tl::make_unexpected(connection.error());
    return *connection;
  }

  Status write(std::size_t topic, Time t, std::span<const std::byte> data) override {
    if (sink_.full()) return {};
    return bag_.write(static_cast<std::uint32_t>(topic), t, data);
  }

  void cut() override { sink_.cut_after(kStump_bytes); }

  Status close() override {
    if (Status s = bag_.close(); !s) return s;
    return sink_.commit();
  }

  wire::Encoding encoding() const override { return wire::Encoding::kRos1; }

 private:
  CutSink sink_;
  io::BagWriter bag_;
};

/// SQLite writes the database itself, so a folder cannot be written atomically as `.NAME.tmp`. It
/// is created as `.NAME.tmp/NAME` and moved when complete.
class Rosbag2Container final : public Container {
 public:
  Rosbag2Container(std::unique_ptr<io::Db3Writer> writer, fs::path nest, fs::path folder)
      : writer_(std::move(writer)), nest_(std::move(nest)), folder_(std::move(folder)) {}

  ~Rosbag2Container() override {
    writer_.reset();
    std::error_code ignored;
    fs::remove_all(nest_, ignored);
  }

  static Result<std::unique_ptr<Container>> create(const std::string& path) {
    const fs::path folder(path);
    const fs::path nest = io::temporary_path_of(path);
    std::error_code error;
    fs::remove_all(nest, error);  // left by a killed run
    auto writer = io::Db3Writer::create((nest / folder.filename()).string());
    if (!writer) return tl::make_unexpected(writer.error());
    return std::make_unique<Rosbag2Container>(std::move(*writer), nest, folder);
  }

  Result<std::size_t> add_topic(const std::string& topic, const std::string& type) override {
    return writer_->add_topic(topic, ros2_name(type));
  }

  Status write(std::size_t topic, Time t, std::span<const std::byte> data) override {
    return is_cut_ ? Status{} : writer_->write(topic, t, data);
  }

  void cut() override { is_cut_ = true; }

  Status close() override {
    if (Status s = writer_->close(); !s) return s;
    std::error_code error;
    if (is_cut_) {
      // The end of the database is removed: its last pages hold the newest messages.
      const fs::path database = writer_->database_path();
      const std::uintmax_t size = fs::file_size(database, error);
      if (!error) fs::resize_file(database, size - size / 8, error);
      if (error) return failure(error);
    }
    fs::rename(nest_ / folder_.filename(), folder_, error);
    if (error) return failure(error);
    return {};
  }

  wire::Encoding encoding() const override { return wire::Encoding::kCdr; }

 private:
  [[nodiscard]] tl::unexpected<Error> failure(const std::error_code& error) const {
    return fail(ErrorCode::kMachine, folder_.string(), error.message());
  }

  std::unique_ptr<io::Db3Writer> writer_;
  fs::path nest_, folder_;
  bool is_cut_ = false;
};

}  // namespace

Result<std::unique_ptr<Container>> Container::create(const std::string& path,
                                                     RecordingFormat format) {
  if (format == RecordingFormat::kRosbag2) return Rosbag2Container::create(path);
  Result<io::AtomicFile> file = io::AtomicFile::create(path);
  if (!file) return tl::make_unexpected(file.error());
  if (format == RecordingFormat::kBag) return std::make_unique<BagContainer>(std::move(*file));
  return std::make_unique<McapContainer>(std::move(*file));
}

}  // namespace rali::scenario
