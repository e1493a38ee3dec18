#include "rali/io/containers/db3_writer.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>

namespace rali::io {
namespace {

namespace fs = std::filesystem;

// The tables of rosbag2 (rosbag2_storage_sqlite3, schema version 3).
constexpr const char* kTables =
    "PRAGMA journal_mode=MEMORY; PRAGMA synchronous=OFF;"
    "CREATE TABLE schema(schema_version INTEGER PRIMARY KEY,ros_distro TEXT NOT NULL);"
    "CREATE TABLE metadata(id INTEGER PRIMARY KEY,metadata_version INTEGER NOT NULL,"
    "metadata TEXT NOT NULL);"
    "CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT NULL,"
    "serialization_format TEXT NOT NULL,offered_qos_profiles TEXT NOT NULL);"
    "CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,"
    "timestamp INTEGER NOT NULL, data BLOB NOT NULL);"
    "CREATE INDEX timestamp_idx ON messages (timestamp ASC);"
    "INSERT INTO schema VALUES(3,'humble');"
    "BEGIN;";

}  // namespace

Result<std::unique_ptr<Db3Writer>> Db3Writer::create(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(ErrorCode::kMachine, folder, "cannot be created: " + error.message());
  if (!fs::is_empty(folder, error) || error) {
    return fail(ErrorCode::kUsage, folder, "folder is not empty", "Name a new one.");
  }
  // "a/b/" has no file name; its parent path has.
  fs::path base = fs::path(folder).lexically_normal();
  if (!base.has_filename()) base = base.parent_path();
  const std::string path = (fs::path(folder) / (base.filename().string() + "_0.db3")).string();
  auto database = SqlDatabase::create(path);
  if (!database) return tl::make_unexpected(database.error());
  std::unique_ptr<Db3Writer> writer(new Db3Writer(std::move(*database), folder, path));
  if (const Status status = writer->start(); !status) return tl::make_unexpected(status.error());
  return writer;
}

Status Db3Writer::start() {
  if (const Status status = database_.run(kTables); !status) return status;
  insert_ =
      database_.prepare("INSERT INTO messages(topic_id, timestamp, data) VALUES (?1, ?2, ?3)");
  if (!insert_) return fail(ErrorCode::kMachine, path_, database_.last_error());
  return {};
}

Result<std::size_t> Db3Writer::add_topic(const std::string& name, const std::string& type,
                                         const std::string& serialization_format) {
  if (closed_) return fail(ErrorCode::kUsage, path_, "written to after it was closed");
  auto insert = database_.prepare("INSERT INTO topics VALUES (?1, ?2, ?3, ?4, '')");
  if (!insert) return fail(ErrorCode::kMachine, path_, database_.last_error());
  insert->bind(1, static_cast<std::int64_t>(topics_.size() + 1));
  insert->bind(2, name);
  insert->bind(3, type);
  insert->bind(4, serialization_format);
  if (insert->step() != SqlStatement::Step::kDone) {
    return fail(ErrorCode::kMachine, path_, "cannot be written: " + database_.last_error());
  }
  topics_.push_back({name, type, serialization_format, 0});
  return topics_.size() - 1;
}

Status Db3Writer::write(std::size_t topic, Time t, std::span<const std::byte> data) {
  if (closed_) return fail(ErrorCode::kUsage, path_, "written to after it was closed");
  if (topic >= topics_.size()) {
    return fail(ErrorCode::kUsage, path_, fmt::format("no topic {}", topic));
  }
  insert_->reset();
  insert_->bind(1, static_cast<std::int64_t>(topic + 1));
  insert_->bind(2, t.ns);
  insert_->bind(3, data);
  if (insert_->step() != SqlStatement::Step::kDone) {
    return fail(ErrorCode::kMachine, path_, "cannot be written: " + database_.last_error());
  }
  first_ = messages_ == 0 ? t : std::min(first_, t);
  last_ = messages_ == 0 ? t : std::max(last_, t);
  ++topics_[topic].messages;
  ++messages_;
  return {};
}

std::string Db3Writer::metadata() const {
  const std::string file = fs::path(path_).filename().string();
  const std::int64_t duration_ns = (last_ - first_).ns;
  std::string out = fmt::format(
      "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: sqlite3\n"
      "  duration:\n    nanoseconds: {}\n  starting_time:\n    nanoseconds_since_epoch: {}\n"
      "  message_count: {}\n  topics_with_message_count:{}\n",
      duration_ns, first_.ns, messages_, topics_.empty() ? " []" : "");
  for (const TopicRow& topic : topics_) {
    out += fmt::format(
        "    - topic_metadata:\n        name: {}\n        type: {}\n"
        "        serialization_format: {}\n        offered_qos_profiles: \"\"\n"
        "      message_count: {}\n",
        topic.name, topic.type, topic.format, topic.messages);
  }
  out += fmt::format(
      "  compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n    - {}\n"
      "  files:\n    - path: {}\n      starting_time:\n        nanoseconds_since_epoch: {}\n"
      "      duration:\n        nanoseconds: {}\n      message_count: {}\n",
      file, file, first_.ns, duration_ns, messages_);
  return out;
}

Status Db3Writer::close() {
  if (closed_) return fail(ErrorCode::kUsage, path_, "written to after it was closed");
  closed_ = true;
  insert_.reset();
  if (const Status status = database_.run("COMMIT"); !status) return status;
  std::ofstream file(fs::path(folder_) / "metadata.yaml", std::ios::binary);
  file << metadata();
  file.close();
  if (file) return {};
  return fail(ErrorCode::kMachine, folder_ + "/metadata.yaml", "cannot be written");
}

}  // namespace rali::io
