#include "rali/host/record_writer.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "rali/wire/definitions.hpp"

namespace rali::host {

RecordWriter::RecordWriter(io::AtomicFile file)
    : sink_(std::move(file)), mcap_(sink_, io::McapWriter::Options{}) {}

Result<std::unique_ptr<RecordWriter>> RecordWriter::create(const std::string& folder,
                                                           const std::string& vehicle) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return fail(ErrorCode::kMachine, folder, "could not be made: " + error.message(),
                "Name a folder that can be written.");
  }
  const std::string path = folder + '/' + vehicle + ".mcap";
  if (std::filesystem::exists(path, error)) {
    return fail(ErrorCode::kUsage, path, "is there already", "Name another folder for --record.");
  }
  Result<io::AtomicFile> file = io::AtomicFile::create(path);
  if (!file) return tl::make_unexpected(file.error());
  return std::unique_ptr<RecordWriter>(new RecordWriter(std::move(*file)));
}

Status RecordWriter::write(const net::RosTopic& topic, Time t_arrival,
                           std::span<const std::byte> cdr) {
  auto channel = channels_.find(topic.name);
  if (channel == channels_.end()) {
    auto schema = schemas_.find(topic.type);
    if (schema == schemas_.end()) {
      const Result<std::uint16_t> id = mcap_.add_schema(
          topic.type, "ros2msg", wire::message_definition(topic.type, wire::Encoding::kCdr));
      if (!id) return tl::make_unexpected(id.error());
      schema = schemas_.emplace(topic.type, *id).first;
    }
    const Result<std::uint16_t> id = mcap_.add_channel(schema->second, topic.name, "cdr");
    if (!id) return tl::make_unexpected(id.error());
    channel = channels_.emplace(topic.name, *id).first;
  }
  const Time t = std::max(t_arrival, Time{});
  return mcap_.write(channel->second, t, t, cdr);
}

Status RecordWriter::finish() {
  if (Status status = mcap_.close(); !status) return status;
  return sink_.commit();
}

}  // namespace rali::host
