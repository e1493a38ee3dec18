#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "rali/base/counted.hpp"
#include "rali/inspect/doctor.hpp"
#include "rali/inspect/info.hpp"
#include "rali/io/files/text.hpp"

namespace rali::inspect {
namespace {

using Json = nlohmann::ordered_json;

std::string size_text(std::uint64_t bytes) {
  const auto b = static_cast<double>(bytes);
  if (b < 1e6) return fmt::format("{:.1f} kB", b / 1e3);
  return b < 1e9 ? fmt::format("{:.1f} MB", b / 1e6) : fmt::format("{:.2f} GB", b / 1e9);
}

/// Names from a file: printable and short, without quotation marks.
std::string plain(const std::string& text, std::size_t max = 40) {
  const std::string q = io::quoted(text, max);
  return q.size() >= 2 ? q.substr(1, q.size() - 2) : q;
}

std::string value_text(const std::optional<double>& v) {
  return v ? fmt::format("{:.10g}", *v) : std::string("-");
}

Json number(const std::optional<double>& v) {
  return v && std::isfinite(*v) ? Json(*v) : Json(nullptr);
}

void add_topics(const FileInfo& info, std::string& out) {
  std::size_t name_width = 5, type_width = 4;
  for (const TopicInfo& t : info.topics) {
    name_width = std::max(name_width, std::min<std::size_t>(t.name.size(), 60));
    type_width = std::max(type_width, std::min<std::size_t>(t.type.size(), 50));
  }
  out += fmt::format("  {:<{}}  {:<{}} {:>9} {:>9}\n", "topic", name_width, "type", type_width,
                     "messages", "Hz");
  for (const TopicInfo& t : info.topics) {
    out += fmt::format("  {:<{}}  {:<{}} {:>9} {:>9.2f}\n", plain(t.name, 60), name_width,
                       plain(t.type, 50), type_width, t.messages, t.rate_hz);
    if (!t.advice.empty()) out += fmt::format("      {}\n", t.advice);
  }
}

void add_cloud(const CloudInfo& cloud, std::string& out) {
  out += fmt::format("first cloud{}: {} x {} points of {} bytes{}{}\n",
                     cloud.topic.empty() ? "" : " of " + plain(cloud.topic, 200), cloud.width,
                     cloud.height, cloud.point_step, cloud.big_endian ? ", big endian" : "",
                     cloud.frame_id.empty() ? "" : ", frame " + plain(cloud.frame_id));
  out += fmt::format("  {:<16} {:<8} {:>6} {:>5} {:>18} {:>18} {:>18}\n", "field", "type", "offset",
                     "count", "first", "smallest", "largest");
  for (const CloudInfo::Field& f : cloud.fields) {
    out +=
        fmt::format("  {:<16} {:<8} {:>6} {:>5} {:>18} {:>18} {:>18}\n", plain(f.name), f.type,
                    f.offset, f.count, value_text(f.first), value_text(f.low), value_text(f.high));
  }
  if (!cloud.summary.empty()) out += fmt::format("  read as: {}\n", cloud.summary);
}

Json cloud_json(const CloudInfo& cloud) {
  Json j;
  j["topic"] = cloud.topic;
  j["frame_id"] = cloud.frame_id;
  j["stamp_s"] = io::format_stamp(cloud.stamp);
  j["width"] = cloud.width;
  j["height"] = cloud.height;
  j["point_step"] = cloud.point_step;
  j["big_endian"] = cloud.big_endian;
  j["fields"] = Json::array();
  for (const CloudInfo::Field& f : cloud.fields) {
    Json field;
    field["name"] = f.name;
    field["type"] = f.type;
    field["offset"] = f.offset;
    field["count"] = f.count;
    field["first"] = number(f.first);
    field["min"] = number(f.low);
    field["max"] = number(f.high);
    j["fields"].push_back(std::move(field));
  }
  j["read_as"] = cloud.summary;
  return j;
}

}  // namespace

std::string info_text(const FileInfo& info) {
  std::string out =
      fmt::format("{}: {}, {}, {}\n", info.path, info.kind, size_text(info.bytes),
                  info.kind == "recording" ? "compression " + info.compression : info.compression);
  if (info.kind == "folder of scans") out += counted(info.messages, "scan") + '\n';
  if (info.has_span) {
    out += fmt::format("{}, {:.3f} s from {} to {}\n", counted(info.messages, "message"),
                       seconds_between(info.t_start, info.t_end), io::format_stamp(info.t_start),
                       io::format_stamp(info.t_end));
  }
  if (info.truncated) out += "the end of the file is missing\n";
  if (info.unindexed) out += "no index: read from front to end\n";
  for (const std::string& note : info.notes) out += note + "\n";
  if (!info.topics.empty()) add_topics(info, out);
  if (info.cloud) add_cloud(*info.cloud, out);
  for (const Finding& f : info.findings) {
    out += fmt::format("{}: {}\n", severity_name(f.severity), f.text);
  }
  return out;
}

std::string info_json(const FileInfo& info) {
  Json j;
  j["schema"] = 2;
  j["path"] = info.path;
  j["kind"] = info.kind;
  j["bytes"] = info.bytes;
  j["compression"] = info.compression;
  j["messages"] = info.messages;
  j["start_s"] = info.has_span ? Json(io::format_stamp(info.t_start)) : Json(nullptr);
  j["end_s"] = info.has_span ? Json(io::format_stamp(info.t_end)) : Json(nullptr);
  j["truncated"] = info.truncated;
  j["unindexed"] = info.unindexed;
  j["topics"] = Json::array();
  for (const TopicInfo& t : info.topics) {
    j["topics"].push_back({{"name", t.name},
                           {"type", t.type},
                           {"encoding", t.encoding},
                           {"messages", t.messages},
                           {"rate_hz", number(t.rate_hz)},
                           {"advice", t.advice}});
  }
  j["cloud"] = info.cloud ? cloud_json(*info.cloud) : Json(nullptr);
  j["notes"] = info.notes;
  j["findings"] = Json::array();
  for (const Finding& f : info.findings) {
    j["findings"].push_back({{"severity", severity_name(f.severity)}, {"text", f.text}});
  }
  return j.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace rali::inspect
