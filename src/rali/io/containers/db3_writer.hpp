#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/io/containers/sqlite_db.hpp"

namespace rali::io {

/// Writes a rosbag2 folder with one uncompressed .db3 and its metadata.yaml, as `ros2 bag record`
/// of ROS 2 Humble and later does. The same bytes for the same calls and version of SQLite.
class Db3Writer {
 public:
  /// Creates `folder`, which must not exist or must be empty.
  [[nodiscard]] static Result<std::unique_ptr<Db3Writer>> create(const std::string& folder);

  /// Returns the number that write() takes. `type` as in ROS 2: "sensor_msgs/msg/Imu".
  [[nodiscard]] Result<std::size_t> add_topic(const std::string& name, const std::string& type,
                                              const std::string& serialization_format = "cdr");

  [[nodiscard]] Status write(std::size_t topic, Time t, std::span<const std::byte> data);

  /// Ends the database and writes metadata.yaml; nothing may be written afterwards.
  [[nodiscard]] Status close();

  [[nodiscard]] const std::string& database_path() const { return path_; }

 private:
  struct TopicRow {
    std::string name;
    std::string type;
    std::string format;
    std::uint64_t messages = 0;
  };

  Db3Writer(SqlDatabase database, std::string folder, std::string path)
      : database_(std::move(database)), folder_(std::move(folder)), path_(std::move(path)) {}

  Status start();
  [[nodiscard]] std::string metadata() const;

  SqlDatabase database_;
  std::optional<SqlStatement> insert_;
  std::string folder_;
  std::string path_;
  std::vector<TopicRow> topics_;
  std::uint64_t messages_ = 0;
  Time first_;
  Time last_;
  bool closed_ = false;
};

}  // namespace rali::io
