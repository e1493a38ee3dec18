#include "rali/inspect/recording_reading.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "rali/base/counted.hpp"
#include "rali/drive/input/sorted_source.hpp"
#include "rali/drive/input/tf_tree.hpp"
#include "rali/inspect/make_finding.hpp"
#include "rali/io/message_source.hpp"
#include "rali/wire/decode.hpp"
#include "rali/wire/message_kind.hpp"

namespace rali::inspect {
namespace {

/// tf trees are small; a file with only transforms must not exhaust the memory.
constexpr std::size_t kTransformsMax = 10000;

struct Counted {
  std::string name;
  std::uint64_t messages = 0;
  wire::MessageKind kind = wire::MessageKind::kOther;
};

/// Reads a recording of messages into an Examination.
class RecordingReading {
 public:
  RecordingReading(const DoctorOptions& options, Examination& examination, RangeStudy& ranges,
                   DoctorReport& report)
      : options_(options), examination_(examination), ranges_(ranges), report_(report) {}

  [[nodiscard]] Status read() {
    const auto known = [](const io::Topic& topic) {
      return wire::message_kind(topic.type) != wire::MessageKind::kOther;
    };
    auto opened = drive::open_in_order(options_.path, known, options_.seconds);
    if (!opened) return tl::make_unexpected(opened.error());
    source_ = std::move(opened->source);
    choose_known_topics();
    io::RawMessage message;
    while (true) {
      const auto more = source_->next(message);
      if (!more) {
        broken_ = more.error().message();
        break;
      }
      if (!*more) break;
      count(message);
      if (is_enough(message.t_record)) {
        partly_ = true;
        break;
      }
      take(message);
    }
    note_range_topics();
    report_topics();
    report_file();
    return {};
  }

  [[nodiscard]] double data_s() const { return seconds_between(t_first_, t_last_); }

  [[nodiscard]] double fraction_read() const { return std::clamp(source_->progress(), 1e-3, 1.0); }

  /// Seconds of the recording after the examined part, if an index shows them.
  [[nodiscard]] double rest_s() const {
    const auto span = source_->span();
    return partly_ && span ? std::max(0.0, seconds_between(t_last_, span->second)) : 0.0;
  }

  void find_extrinsics() {
    report_.T_body_lidar = options_.T_body_lidar;
    if (options_.T_body_lidar || report_.lidar_frame.empty() || report_.imu_frame.empty()) return;
    const auto T_imu_lidar = tf_.find(report_.imu_frame, report_.lidar_frame);
    if (T_imu_lidar) report_.T_body_lidar = options_.T_body_imu * *T_imu_lidar;
  }

 private:
  /// With an index, the topic with the most messages of its kind is taken.
  void choose_known_topics() {
    report_.lidar_topic = options_.lidar_topic;
    report_.imu_topic = options_.imu_topic;
    std::uint64_t max_cloud = 0, max_imu = 0;
    for (const io::Topic& topic : source_->topics()) {
      const wire::MessageKind kind = wire::message_kind(topic.type);
      const std::uint64_t n = topic.messages.value_or(0);
      if (options_.lidar_topic.empty() && wire::is_cloud(kind) && n > max_cloud) {
        report_.lidar_topic = topic.name;
        max_cloud = n;
      }
      if (options_.imu_topic.empty() && kind == wire::MessageKind::kImu && n > max_imu) {
        report_.imu_topic = topic.name;
        max_imu = n;
      }
    }
  }

  void count(const io::RawMessage& message) {
    while (counted_.size() < source_->topics().size()) {
      const io::Topic& topic = source_->topics()[counted_.size()];
      counted_.push_back({topic.name, 0, wire::message_kind(topic.type)});
    }
    ++counted_[message.topic].messages;
    if (t_first_.ns == 0) t_first_ = t_last_ = message.t_record;
    t_last_ = std::max(t_last_, message.t_record);
  }

  [[nodiscard]] bool is_enough(Time t_record) const {
    return options_.seconds > 0.0 && seconds_between(t_first_, t_record) > options_.seconds;
  }

  void take(const io::RawMessage& message) {
    using wire::MessageKind;
    const io::Topic& topic = source_->topics()[message.topic];
    const MessageKind kind = counted_[message.topic].kind;
    if (wire::is_cloud(kind)) return take_cloud(kind, topic, message);
    if (kind == MessageKind::kImu) return take_imu(topic, message);
    if (kind == MessageKind::kTf) return take_tf(topic, message);
    if (kind == MessageKind::kLinktrack) return take_linktrack(topic, message);
    if (kind == MessageKind::kRaliRange) take_range(topic, message);
  }

  void take_cloud(wire::MessageKind kind, const io::Topic& topic, const io::RawMessage& message) {
    if (report_.lidar_topic.empty()) report_.lidar_topic = topic.name;
    if (topic.name != report_.lidar_topic) return;
    std::vector<std::byte> bytes(message.data.begin(), message.data.end());
    auto view = wire::decode_cloud_message(kind, bytes, topic.encoding);
    if (!view) return examination_.add_undecodable(topic.name, view.error().message());
    if (report_.lidar_frame.empty()) report_.lidar_frame = view->frame_id;
    examination_.add_cloud(std::move(bytes), std::move(*view), message.t_record);
  }

  void take_imu(const io::Topic& topic, const io::RawMessage& message) {
    if (report_.imu_topic.empty()) report_.imu_topic = topic.name;
    if (topic.name != report_.imu_topic) return;
    const auto imu = wire::decode_imu(message.data, topic.encoding);
    if (!imu) return examination_.add_undecodable(topic.name, imu.error().message());
    if (report_.imu_frame.empty()) report_.imu_frame = imu->frame_id;
    examination_.add_imu(imu->sample, message.t_record);
  }

  void take_tf(const io::Topic& topic, const io::RawMessage& message) {
    if (topic.name.find("tf_static") == std::string::npos) return;
    const auto tf = wire::decode_tf(message.data, topic.encoding);
    if (!tf) return examination_.add_undecodable(topic.name, tf.error().message());
    for (const wire::TransformStamped& t : tf->transforms) {
      if (transforms_++ < kTransformsMax) tf_.add(t);
    }
  }

  /// Name of the radio with this number on a range topic; empty: the topic is not used.
  [[nodiscard]] std::string radio_name(const std::string& topic, std::int64_t number) const {
    if (!options_.range_topics) return fmt::format("{}", number);
    for (const RangeTopicNames& names : *options_.range_topics) {
      if (names.topic != topic) continue;
      const auto name = names.names.find(number);
      return name == names.names.end() ? fmt::format("{}", number) : name->second;
    }
    return {};
  }

  /// As in rali map: a fleet's radio that no list names belongs to the recording's vehicle.
  [[nodiscard]] std::string own_radio(const std::string& topic, std::int64_t number) const {
    const std::string name = radio_name(topic, number);
    const bool unlisted = options_.range_topics && name == fmt::format("{}", number);
    return unlisted ? options_.vehicle : name;
  }

  void take_linktrack(const io::Topic& topic, const io::RawMessage& message) {
    const auto frame = wire::decode_linktrack(topic.type, message.data, topic.encoding);
    if (!frame) return examination_.add_undecodable(topic.name, frame.error().message());
    const std::string from = own_radio(topic.name, frame->id);
    if (from.empty()) return;
    ranges_.add_radio(topic.name, options_.vehicle, frame->id, frame->stamp.ns != 0);
    const Time t = frame->stamp.ns != 0 ? frame->stamp : message.t_record;
    for (const wire::LinktrackNode& node : frame->nodes) {
      const std::string to = radio_name(topic.name, node.id);
      ranges_.add_peer(topic.name, node.id);
      if (to != from) ranges_.add(t, from, to, node.range_m);
    }
    ranges_.add_zeros(frame->zeros);
  }

  void take_range(const io::Topic& topic, const io::RawMessage& message) {
    const auto range = wire::decode_range(message.data, topic.encoding);
    if (!range) return examination_.add_undecodable(topic.name, range.error().message());
    if (radio_name(topic.name, 0).empty()) return;
    const Time t = range->stamp.ns != 0 ? range->stamp : message.t_record;
    ranges_.add_radio(topic.name, options_.vehicle, std::nullopt, range->stamp.ns != 0);
    ranges_.add(t, range->from, range->to, range->range_m);
  }

  /// Notes the range topics. For the unread part the index gives the topics; without an index a
  /// range topic may still have messages later.
  void note_range_topics() {
    for (std::size_t i = 0; i < source_->topics().size(); ++i) {
      const io::Topic& topic = source_->topics()[i];
      const wire::MessageKind kind = wire::message_kind(topic.type);
      if (kind != wire::MessageKind::kLinktrack && kind != wire::MessageKind::kRaliRange) continue;
      const bool read = i < counted_.size() && counted_[i].messages > 0;
      const bool later = partly_ && topic.messages.value_or(1) > 0;
      if (read || later) ranges_.add_topic(topic.name);
    }
  }

  void report_topics() {
    std::vector<std::string> clouds, advice;
    for (const Counted& c : counted_) {
      if (wire::is_cloud(c.kind)) clouds.push_back(fmt::format("{} ({})", c.name, c.messages));
      const auto text = wire::kind_advice(c.kind);
      if (!text.empty()) advice.push_back(fmt::format("{}: {}", c.name, text));
    }
    if (clouds.size() > 1) {
      report_.findings.push_back(make_finding(
          "D01", Severity::kWarning, report_.lidar_topic,
          {fmt::format("{} point cloud topics: {}", clouds.size(), fmt::join(clouds, ", ")),
           "this report is about " + report_.lidar_topic + "; rali map asks which one to take",
           "Choose with --lidar-topic or vehicles." + options_.vehicle + ".lidar.topic."},
          {static_cast<double>(clouds.size()), 1.0}));
    }
    if (examination_.clouds() > 0) return;
    const bool named = !options_.lidar_topic.empty();
    report_.findings.push_back(make_finding(
        "D01", Severity::kError, options_.lidar_topic,
        {named            ? "no point clouds on " + options_.lidar_topic
         : advice.empty() ? std::string("no point clouds in this recording")
                          : fmt::format("no point clouds; {}", fmt::join(advice, "; ")),
         "there is nothing to map",
         clouds.empty() ? "Record the LiDAR's PointCloud2."
                        : fmt::format("Clouds are on {}.", fmt::join(clouds, ", "))}));
  }

  void report_file() {
    const io::SourceHealth& health = source_->health();
    for (Finding finding : health.findings) {
      finding.id = "D19";
      report_.findings.push_back(std::move(finding));
    }
    if (!broken_.empty()) {
      report_.findings.push_back(
          make_finding("D19", Severity::kError, "", {broken_, "what comes after is lost", ""}));
    }
    const bool damaged = health.truncated || health.messages_skipped > 0 || health.bytes_lost > 0;
    if (damaged && health.findings.empty()) {
      report_.findings.push_back(make_finding(
          "D19", Severity::kWarning, "",
          {fmt::format("damaged: {} skipped, {} lost", counted(health.messages_skipped, "message"),
                       counted(health.bytes_lost, "byte")),
           "the map ends where the file does", ""},
          {static_cast<double>(health.bytes_lost), 0.0}));
    }
    report_.findings.push_back(make_finding(
        "D19", Severity::kInfo, "",
        {fmt::format("{} read over {:.1f} s, compression {}{}", counted(health.messages, "message"),
                     data_s(), health.compression.empty() ? "none" : health.compression,
                     health.unindexed ? ", no index" : ""),
         "", ""}));
  }

  const DoctorOptions& options_;
  Examination& examination_;
  RangeStudy& ranges_;
  DoctorReport& report_;
  std::unique_ptr<io::MessageSource> source_;
  std::vector<Counted> counted_;
  drive::TfTree tf_;
  std::size_t transforms_ = 0;
  Time t_first_, t_last_;
  bool partly_ = false;  ///< the recording continues after the examined part
  std::string broken_;
};

}  // namespace

Result<ReadingEnd> read_recording(const DoctorOptions& options, Examination& examination,
                                  RangeStudy& ranges, DoctorReport& report) {
  RecordingReading reading(options, examination, ranges, report);
  if (const Status status = reading.read(); !status) return tl::make_unexpected(status.error());
  reading.find_extrinsics();
  return ReadingEnd{reading.data_s(), reading.fraction_read(), reading.rest_s()};
}

}  // namespace rali::inspect
