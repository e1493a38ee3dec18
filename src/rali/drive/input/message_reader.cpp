#include "rali/drive/input/message_reader.hpp"

#include <utility>

#include <fmt/format.h>

#include "rali/wire/decode.hpp"

namespace rali::drive {
namespace {

/// Damaged messages reported individually; further ones are only counted.
constexpr std::uint64_t kNamedErrors = 5;

std::string prefixed(const std::string& place, std::string text) {
  return place.empty() ? std::move(text) : place + ": " + text;
}

}  // namespace

MessageReader::MessageReader(const RecordingProbe& probe, const InputOptions& options,
                             PlaceOf place)
    : topics_(probe.topics),
      format_(probe.format),
      options_(options),
      clock_offset_(Duration::from_s(options.clock_offset.value_s)),
      place_(std::move(place)),
      lidar_stamps_(probe.lidar_stamps, shifts_),
      imu_stamps_(probe.imu_stamps, shifts_),
      intake_(probe.units),
      range_topics_(options.ranges, options.self, probe.clock_ahead) {}

void MessageReader::start_file(bool clock_was_set) {
  lidar_stamps_.start_file(clock_was_set);
  imu_stamps_.start_file(clock_was_set);
}

void MessageReader::take(const RecordedMessage& message, EventSink& sink, InputReport& report) {
  if (message.topic == topics_.lidar && wire::is_cloud(message.kind)) {
    take_cloud(message, sink, report);
  } else if (message.topic == topics_.imu && message.kind == wire::MessageKind::kImu) {
    take_imu(message, sink, report);
  } else if (range_topics_.wants(message)) {
    take_ranges(message, sink, report);
  }
}

void MessageReader::take_ranges(const RecordedMessage& message, EventSink& sink,
                                InputReport& report) {
  ++report.range_messages[std::string(message.topic)];
  ranges_.clear();
  if (Status s = range_topics_.take(message, ranges_); !s) {
    return damaged(message, s.error(), report);
  }
  for (sensor::RangeSample& sample : ranges_) {
    sample.t = sample.t + clock_offset_;
    sample.clock = options_.self;
    sink.push(sample);
  }
}

void MessageReader::take_cloud(const RecordedMessage& message, EventSink& sink,
                               InputReport& report) {
  const Result<wire::CloudView> view =
      wire::decode_cloud_message(message.kind, message.data, message.encoding);
  if (!view) return damaged(message, view.error(), report);
  auto scan = std::make_shared<sensor::LidarScan>();
  if (Status s = wire::decode_cloud(*view, format_, options_.cloud, *scan); !s) {
    return damaged(message, s.error(), report);
  }
  if (scan->size() == 0) return sink.push(std::move(scan));
  const std::optional<Time> t_end =
      repair(lidar_stamps_, {scan->t_end, message.t_record}, message, report);
  if (!t_end) return;
  const Duration shift =
      *t_end - scan->t_end + clock_offset_ + Duration::from_s(options_.lidar_time_offset.value_s);
  scan->t_start = scan->t_start + shift;
  scan->t_end = scan->t_end + shift;
  sink.push(std::move(scan));
}

void MessageReader::take_imu(const RecordedMessage& message, EventSink& sink, InputReport& report) {
  Result<wire::ImuMessage> imu = wire::decode_imu(message.data, message.encoding);
  if (!imu) return damaged(message, imu.error(), report);
  const std::optional<Time> t =
      repair(imu_stamps_, {imu->sample.t, message.t_record}, message, report);
  if (!t) return;
  imu->sample.t = *t + clock_offset_;
  if (const auto sample = intake_.take(imu->sample, report.gaps)) sink.push(*sample);
}

std::optional<Time> MessageReader::repair(StampRepair& repair, StampPair stamps,
                                          const RecordedMessage& message, InputReport& report) {
  const std::uint64_t jumps = repair.jumps();
  const std::optional<Time> t = repair.repair(stamps);
  report.gaps.repeated = lidar_stamps_.repeats() + imu_stamps_.repeats();
  report.gaps.jumps = lidar_stamps_.jumps() + imu_stamps_.jumps();
  if (repair.jumps() == jumps || repair.jumps() > kNamedErrors) return t;
  Finding f;
  f.id = "D04";
  f.vehicle = report.vehicle;
  f.topic = message.topic;
  f.t = t ? *t + clock_offset_ : Time{};
  f.text =
      prefixed(place_(message), fmt::format("stamps of {} jump by {:+.3f} s; the jump is closed",
                                            message.topic, repair.last_jump_s()));
  f.value = repair.last_jump_s();
  report.findings.push_back(std::move(f));
  return t;
}

void MessageReader::damaged(const RecordedMessage& message, const Error& error,
                            InputReport& report) const {
  report.gaps.damaged = true;
  if (++report.gaps.undecodable > kNamedErrors) return;
  Finding f;
  f.id = "D19";
  f.vehicle = report.vehicle;
  f.topic = message.topic;
  f.text = prefixed(place_(message),
                    fmt::format("message of {} left out: {}", message.topic, error.message()));
  report.findings.push_back(std::move(f));
}

}  // namespace rali::drive
