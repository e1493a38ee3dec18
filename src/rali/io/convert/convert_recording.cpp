#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "rali/base/counted.hpp"
#include "rali/io/containers/mcap_writer.hpp"
#include "rali/io/convert/convert.hpp"
#include "rali/io/files/file_sink.hpp"
#include "rali/io/message_source.hpp"
#include "rali/wire/decode.hpp"
#include "rali/wire/definitions.hpp"
#include "rali/wire/encode.hpp"

namespace rali::io {
namespace {

using wire::Encoding;
using wire::MessageKind;

constexpr std::uint64_t kAskEvery = 512;  ///< messages between two calls of go_on

std::string profile_of(const std::vector<Topic>& topics) {
  bool ros1 = false, cdr = false;
  for (const Topic& topic : topics) {
    ros1 = ros1 || topic.encoding == Encoding::kRos1;
    cdr = cdr || topic.encoding == Encoding::kCdr;
  }
  if (ros1 == cdr) return "";
  return ros1 ? "ros1" : "ros2";
}

/// Format of a definition's text, in MCAP's names.
std::string schema_encoding(const Topic& topic, const std::string& definition) {
  if (definition.empty()) return "";
  if (topic.encoding == Encoding::kRos1) return "ros1msg";
  if (topic.encoding == Encoding::kCdr) {
    // rosbag2 separates the files of an IDL definition by lines "IDL: package/Type".
    return definition.find("\nIDL: ") != std::string::npos ? "ros2idl" : "ros2msg";
  }
  if (topic.encoding_name == "json") return "jsonschema";
  return topic.encoding_name;
}

/// Writes the messages of one recording into an MCAP.
class RecordingCopy {
 public:
  RecordingCopy(MessageSource& source, McapWriter& mcap, const std::string& path)
      : source_(source), mcap_(mcap), path_(path) {}

  /// Writes one message: unchanged, or a CustomMsg as PointCloud2.
  Status add(const RawMessage& message) {
    if (message.t_record.ns < 0) {
      ++before_1970_;
      return {};
    }
    const Topic& topic = source_.topics()[message.topic];
    if (wire::message_kind(topic.type) != MessageKind::kLivoxCustom ||
        topic.encoding == Encoding::kOther) {
      return write(message, topic, topic.type, topic.definition, message.data);
    }
    const auto cloud = wire::decode_livox_custom(message.data, topic.encoding);
    if (!cloud) {
      if (undecoded_++ == 0) first_undecoded_ = message.offset;
      return {};
    }
    ++livox_;
    const std::string type = topic.encoding == Encoding::kRos1 ? "sensor_msgs/PointCloud2"
                                                               : "sensor_msgs/msg/PointCloud2";
    return write(message, topic, type, "", wire::encode(*cloud, topic.encoding));
  }

  [[nodiscard]] Conversion result() const;

 private:
  /// The channel of a topic, created with its first message.
  Result<std::uint16_t> channel_of(std::size_t index, const Topic& topic, const std::string& type,
                                   std::string definition) {
    if (const auto known = channels_.find(index); known != channels_.end()) return known->second;
    if (definition.empty() && topic.encoding != Encoding::kOther) {
      definition = wire::message_definition(type, topic.encoding);
    }
    if (definition.empty()) undefined_.push_back(topic.name);
    const auto key = std::pair(type, definition);
    auto schema = schemas_.find(key);
    if (schema == schemas_.end()) {
      const auto id = mcap_.add_schema(type, schema_encoding(topic, definition), definition);
      if (!id) return tl::make_unexpected(id.error());
      schema = schemas_.emplace(key, *id).first;
    }
    const auto id = mcap_.add_channel(schema->second, topic.name, topic.encoding_name);
    if (id) channels_.emplace(index, *id);
    return id;
  }

  Status write(const RawMessage& message, const Topic& topic, const std::string& type,
               const std::string& definition, std::span<const std::byte> data) {
    const auto channel = channel_of(message.topic, topic, type, definition);
    if (!channel) return tl::make_unexpected(channel.error());
    ++messages_;
    return mcap_.write(*channel, message.t_record, message.t_record, data);
  }

  MessageSource& source_;
  McapWriter& mcap_;
  const std::string& path_;
  std::map<std::size_t, std::uint16_t> channels_;
  std::map<std::pair<std::string, std::string>, std::uint16_t> schemas_;
  std::vector<std::string> undefined_;
  std::uint64_t messages_ = 0, livox_ = 0, before_1970_ = 0, undecoded_ = 0;
  std::uint64_t first_undecoded_ = 0;
};

Conversion RecordingCopy::result() const {
  Conversion out;
  out.done =
      fmt::format("{} of {}", counted(messages_, "message"), counted(channels_.size(), "topic"));
  if (livox_ > 0) out.done += fmt::format(", {} CustomMsg as PointCloud2", livox_);
  if (livox_ > 0) out.lost.emplace_back("lidar_id and timebase of CustomMsg are left out");
  out.lost.emplace_back(
      "publish times become record times; latching, QoS, attachments and metadata are left out");
  for (const std::string& name : undefined_) {
    out.lost.push_back(name +
                       ": the recording has no definition of its messages, so viewers "
                       "cannot decode them");
  }
  if (before_1970_ > 0) {
    out.lost.push_back(counted(before_1970_, "message") +
                       " recorded before 1970, which MCAP cannot hold");
  }
  const SourceHealth& health = source_.health();
  out.findings = health.findings;
  if (undecoded_ > 0) {
    Finding finding;
    finding.id = "io.damaged";
    finding.text = fmt::format("{}:offset {}: {} CustomMsg not decodable, left out", path_,
                               first_undecoded_, undecoded_);
    finding.value = static_cast<double>(undecoded_);
    out.findings.push_back(std::move(finding));
  }
  out.gaps = health.truncated || health.messages_skipped > 0 || undecoded_ > 0 || before_1970_ > 0;
  return out;
}

}  // namespace

Result<Conversion> convert_recording(const std::string& in, const std::string& out,
                                     const ConvertOptions& options) {
  auto source = open_recording(in);
  if (!source) return tl::make_unexpected(source.error());
  auto file = AtomicFile::create(out);
  if (!file) return tl::make_unexpected(file.error());
  FileSink sink(std::move(*file));
  McapWriter::Options target;
  target.profile = profile_of((*source)->topics());
  McapWriter mcap(sink, target);
  RecordingCopy copy(**source, mcap, in);
  RawMessage message;
  for (std::uint64_t n = 1;; ++n) {
    const auto more = (*source)->next(message);
    if (!more) return tl::make_unexpected(more.error());
    if (!*more) break;
    if (Status status = copy.add(message); !status) return tl::make_unexpected(status.error());
    if (n % kAskEvery == 0 && !options.go_on((*source)->progress())) {
      return fail(ErrorCode::kInterrupted, out, "stopped; nothing was written");
    }
  }
  if (Status status = mcap.close(); !status) return tl::make_unexpected(status.error());
  if (Status status = sink.commit(); !status) return tl::make_unexpected(status.error());
  return copy.result();
}

}  // namespace rali::io
