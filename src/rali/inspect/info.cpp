#include "rali/inspect/info.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "rali/io/files/cloud_file.hpp"
#include "rali/io/files/scan_folder.hpp"
#include "rali/io/input_kind.hpp"
#include "rali/io/message_source.hpp"
#include "rali/wire/byte_reader.hpp"
#include "rali/wire/decode.hpp"
#include "rali/wire/message_kind.hpp"

namespace rali::inspect {
namespace {

const char* type_name(wire::FieldType type) {
  constexpr std::array<const char*, 9> kNames{"?",     "int8",   "uint8",   "int16",  "uint16",
                                              "int32", "uint32", "float32", "float64"};
  const auto i = static_cast<std::size_t>(type);
  return i < kNames.size() ? kNames[i] : "?";
}

std::size_t type_bytes(wire::FieldType type) {
  constexpr std::array<std::size_t, 9> kBytes{0, 1, 1, 2, 2, 4, 4, 4, 8};
  const auto i = static_cast<std::size_t>(type);
  return i < kBytes.size() ? kBytes[i] : 0;
}

double value_at(const std::byte* at, wire::FieldType type, bool big_endian) {
  using wire::FieldType;
  switch (type) {
    case FieldType::kInt8:
      return static_cast<double>(wire::load<std::int8_t>(at, big_endian));
    case FieldType::kUint8:
      return static_cast<double>(wire::load<std::uint8_t>(at, big_endian));
    case FieldType::kInt16:
      return static_cast<double>(wire::load<std::int16_t>(at, big_endian));
    case FieldType::kUint16:
      return static_cast<double>(wire::load<std::uint16_t>(at, big_endian));
    case FieldType::kInt32:
      return static_cast<double>(wire::load<std::int32_t>(at, big_endian));
    case FieldType::kUint32:
      return static_cast<double>(wire::load<std::uint32_t>(at, big_endian));
    case FieldType::kFloat32:
      return static_cast<double>(wire::load<float>(at, big_endian));
    case FieldType::kFloat64:
      return wire::load<double>(at, big_endian);
  }
  return 0.0;
}

/// Values of one field; offsets come from the file and are checked.
CloudInfo::Field describe_field(const wire::CloudView& view, const wire::CloudField& field) {
  CloudInfo::Field out{field.name, type_name(field.type), field.offset, field.count, {}, {}, {}};
  const std::size_t bytes = type_bytes(field.type);
  if (bytes == 0 || view.point_step == 0) return out;
  for (std::uint32_t row = 0; row < view.height; ++row) {
    const std::uint64_t row_begin = std::uint64_t{row} * view.row_step + field.offset;
    if (row_begin >= view.data.size()) break;
    for (std::uint32_t i = 0; i < view.width; ++i) {
      const std::uint64_t at = row_begin + std::uint64_t{i} * view.point_step;
      if (at + bytes > view.data.size()) break;
      const double v = value_at(view.data.data() + at, field.type, view.big_endian);
      if (!out.first) out.first = v;
      if (!std::isfinite(v)) continue;
      out.low = std::min(out.low.value_or(v), v);
      out.high = std::max(out.high.value_or(v), v);
    }
  }
  return out;
}

CloudInfo describe_cloud(const wire::CloudView& view, const std::string& topic, bool has_time) {
  CloudInfo out;
  out.topic = topic;
  out.frame_id = view.frame_id;
  out.stamp = view.stamp;
  out.width = view.width;
  out.height = view.height;
  out.point_step = view.point_step;
  out.big_endian = view.big_endian;
  for (const wire::CloudField& field : view.fields) {
    out.fields.push_back(describe_field(view, field));
  }
  if (!has_time) return out;
  const auto format = wire::decide_cloud_format(std::span(&view, 1), wire::CloudFormatOptions{});
  out.summary = format ? format->summary : format.error().message();
  return out;
}

std::uint64_t size_of(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (!fs::is_directory(path, error)) {
    const auto size = fs::file_size(path, error);
    return error ? 0 : size;
  }
  std::uint64_t sum = 0;
  fs::directory_iterator entries(path, error);
  for (const fs::directory_iterator end; !error && entries != end; entries.increment(error)) {
    std::error_code ignored;
    const auto size = entries->file_size(ignored);
    if (!ignored) sum += size;
  }
  return sum;
}

struct Span {
  Time first, last;
};

Result<FileInfo> look_into_recording(const std::string& path) {
  auto opened = io::open_recording(path);
  if (!opened) return tl::make_unexpected(opened.error());
  io::MessageSource& source = **opened;
  FileInfo info;
  info.path = path;
  info.kind = "recording";
  info.bytes = size_of(path);
  std::vector<std::uint64_t> counts;
  std::vector<Span> spans;
  io::RawMessage message;
  std::string broken;
  while (true) {
    const auto more = source.next(message);
    if (!more) broken = more.error().message();
    if (!more || !*more) break;
    counts.resize(source.topics().size());
    spans.resize(source.topics().size());
    Span& span = spans[message.topic];
    if (counts[message.topic]++ == 0) span = {message.t_record, message.t_record};
    span = {std::min(span.first, message.t_record), std::max(span.last, message.t_record)};
    info.t_start = info.has_span ? std::min(info.t_start, message.t_record) : message.t_record;
    info.t_end = info.has_span ? std::max(info.t_end, message.t_record) : message.t_record;
    info.has_span = true;
    const io::Topic& topic = source.topics()[message.topic];
    const wire::MessageKind kind = wire::message_kind(topic.type);
    if (info.cloud || !wire::is_cloud(kind)) continue;
    const auto view = wire::decode_cloud_message(kind, message.data, topic.encoding);
    if (view) info.cloud = describe_cloud(*view, topic.name, true);
  }
  counts.resize(source.topics().size());
  spans.resize(source.topics().size());
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const io::Topic& topic = source.topics()[i];
    TopicInfo t{topic.name, topic.type, topic.encoding_name, counts[i], 0.0, {}};
    t.advice = std::string(wire::kind_advice(wire::message_kind(topic.type)));
    const double span_s = seconds_between(spans[i].first, spans[i].last);
    if (counts[i] > 1 && span_s > 0.0) t.rate_hz = static_cast<double>(counts[i] - 1) / span_s;
    info.topics.push_back(std::move(t));
  }
  const io::SourceHealth& health = source.health();
  info.messages = health.messages;
  info.compression = health.compression.empty() ? "none" : health.compression;
  info.truncated = health.truncated;
  info.damaged = health.truncated || health.messages_skipped > 0 || health.bytes_lost > 0;
  info.unindexed = health.unindexed;
  info.findings = health.findings;
  if (!broken.empty()) info.notes.push_back("reading ended early: " + broken);
  return info;
}

Result<FileInfo> look_into_folder(const std::string& path) {
  Result<io::ScanFolder> folder = io::ScanFolder::open(path);
  if (!folder) return tl::make_unexpected(folder.error());
  FileInfo info;
  info.path = path;
  info.kind = "folder of scans";
  info.bytes = size_of(path);
  info.messages = folder->entries().size();
  info.notes.push_back(folder->times_assumed() ? "no times.txt: 10 Hz is assumed"
                                               : "times.txt is there");
  info.notes.push_back(folder->imu_path() ? "imu.csv is there" : "no imu.csv: LiDAR alone");
  io::CloudFile cloud;
  Time t;
  const Result<bool> any = folder->next(cloud, t);
  if (!any) return tl::make_unexpected(any.error());
  if (!*any) return tl::make_unexpected(folder->none_readable());
  info.damaged = folder->skipped() > 0;
  info.compression = cloud.encoding;
  const std::string& first = folder->entries()[folder->skipped()].path;
  info.cloud = describe_cloud(cloud.view(t, ""), first, false);
  info.findings = folder->findings();
  return info;
}

Result<FileInfo> look_into_cloud(const std::string& path) {
  const auto cloud = io::read_cloud_file(path);
  if (!cloud) return tl::make_unexpected(cloud.error());
  FileInfo info;
  info.path = path;
  info.kind = "point cloud";
  info.bytes = size_of(path);
  info.compression = cloud->encoding;
  info.cloud = describe_cloud(cloud->view(Time{}, ""), "", false);
  info.findings = cloud->findings;
  return info;
}

}  // namespace

Result<FileInfo> look_into(const std::string& path) {
  const Result<io::InputKind> kind = io::input_kind(path);
  if (!kind) return tl::make_unexpected(kind.error());
  switch (*kind) {
    case io::InputKind::kScanFolder:
      return look_into_folder(path);
    case io::InputKind::kCloud:
      return look_into_cloud(path);
    case io::InputKind::kRecording:
      break;
  }
  return look_into_recording(path);
}

}  // namespace rali::inspect
