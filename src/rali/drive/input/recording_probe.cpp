#include "rali/drive/input/recording_probe.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "rali/drive/input/imu_fitness.hpp"
#include "rali/drive/input/imu_intake.hpp"
#include "rali/wire/decode.hpp"

namespace rali::drive {
namespace {

constexpr std::size_t kImuSamples = 20000;

StoredMessage stored(const RecordedMessage& m) {
  return {m.kind,
          std::string(m.topic),
          std::string(m.type),
          m.encoding,
          m.t_record,
          {m.data.begin(), m.data.end()},
          m.offset,
          m.file};
}

/// Reads the first messages; the counts of the topics of the first file go to `topics`.
void read_first(RecordingChain& chain, RecordingProbe& probe, std::vector<TopicCount>& topics,
                InputReport& report) {
  std::size_t bytes = 0, scans = 0;
  std::optional<Time> t_start;
  RecordedMessage message;
  topics = chain.topics();
  while (chain.next(message, report.gaps, report.findings)) {
    bytes += message.data.size();
    if (wire::is_cloud(message.kind)) ++scans;
    probe.messages.push_back(stored(message));
    if (chain.file() == 0) topics = chain.topics();
    if (!t_start) t_start = message.t_record;
    const double span_s = std::abs(message.t_record.s() - t_start->s());
    // Record times may be constant: then four times as many scans suffice.
    if ((scans >= kProbeClouds && span_s >= kProbe_s) || scans >= 4 * kProbeClouds) break;
    if (bytes > kProbeBytes) {
      if (scans > 0) break;
      // Inertial data long before the first scan are useless: only the youngest are kept.
      bytes = 0;
      probe.messages.erase(
          probe.messages.begin(),
          probe.messages.begin() + static_cast<std::ptrdiff_t>(probe.messages.size() / 2));
    }
  }
}

/// Views of the first scans of the chosen topic; they point into the probe's messages.
std::vector<wire::CloudView> first_views(const RecordingProbe& probe) {
  std::vector<wire::CloudView> views;
  for (const StoredMessage& m : probe.messages) {
    if (m.topic != probe.topics.lidar || views.size() >= kProbeClouds) continue;
    Result<wire::CloudView> view = wire::decode_cloud_message(m.kind, m.data, m.encoding);
    if (view) views.push_back(std::move(*view));
  }
  return views;
}

std::vector<sensor::LidarScan> first_scans(std::span<const wire::CloudView> views,
                                           const wire::CloudFormat& format,
                                           const wire::CloudFormatOptions& options) {
  std::vector<sensor::LidarScan> scans;
  for (const wire::CloudView& view : views) {
    sensor::LidarScan scan;
    if (wire::decode_cloud(view, format, options, scan)) scans.push_back(std::move(scan));
    // Three scans fill the gaps between the rings; more only cost time.
    if (scans.size() >= 3) break;
  }
  return scans;
}

struct FirstImu {
  std::vector<sensor::ImuSample> samples;
  std::vector<StampPair> stamps;
};

FirstImu first_imu(const RecordingProbe& probe, InputReport& report) {
  FirstImu first;
  if (probe.topics.imu.empty()) return first;
  for (const StoredMessage& m : probe.messages) {
    if (m.topic != probe.topics.imu) continue;
    const Result<wire::ImuMessage> imu = wire::decode_imu(m.data, m.encoding);
    if (!imu) continue;
    report.imu_frame = imu->frame_id;
    first.stamps.push_back({imu->sample.t, m.t_record});
    if (first.samples.size() >= kImuSamples || !is_plausible(imu->sample)) continue;
    first.samples.push_back(imu->sample);
  }
  return first;
}

bool has_absolute_times(const wire::CloudFormat& format) {
  return (format.point_time == wire::PointTime::kAbsoluteS ||
          format.point_time == wire::PointTime::kAbsoluteNs) &&
         !format.anchor_to_header;
}

/// Stamps that the scans will carry: of the header, or of the points if these are absolute.
std::vector<StampPair> lidar_stamps(const RecordingProbe& probe,
                                    const wire::CloudFormatOptions& options) {
  std::vector<StampPair> pairs;
  sensor::LidarScan scan;
  for (const StoredMessage& m : probe.messages) {
    if (m.topic != probe.topics.lidar) continue;
    const Result<wire::CloudView> view = wire::decode_cloud_message(m.kind, m.data, m.encoding);
    if (!view) continue;
    Time t = view->stamp;
    if (has_absolute_times(probe.format)) {
      if (!wire::decode_cloud(*view, probe.format, options, scan) || scan.size() == 0) continue;
      t = scan.t_end;
    }
    pairs.push_back({t, m.t_record});
  }
  return pairs;
}

void stamp_finding(InputReport& report, const std::string& topic, const std::string& reason) {
  Finding f;
  f.id = "D04";
  f.vehicle = report.vehicle;
  f.topic = topic;
  f.text = fmt::format("{}: {}; the record time is used", topic, reason);
  f.effect = "Record times jitter by milliseconds.";
  report.findings.push_back(std::move(f));
}

/// Uses record times if headers are unreliable or the two sensors run on two clocks.
void choose_stamps(RecordingProbe& probe, std::span<const StampPair> lidar,
                   std::span<const StampPair> imu, InputReport& report) {
  StampDecision by_lidar = decide_stamps(lidar);
  StampDecision by_imu = decide_stamps(imu);
  const std::optional<double> lidar_s = clock_offset_s(lidar), imu_s = clock_offset_s(imu);
  const bool both = by_lidar.rule == StampRule::kHeader && by_imu.rule == StampRule::kHeader;
  if (both && lidar_s && imu_s && std::abs(*lidar_s - *imu_s) > kClockSplitS) {
    const std::string reason = fmt::format(
        "stamps of LiDAR and IMU are {:.1f} s apart at the same record time (two clocks)",
        std::abs(*lidar_s - *imu_s));
    // The clock farther from the recorder's is replaced; a boot clock is farther than any other.
    const bool lidar_farther = std::abs(*lidar_s) > std::abs(*imu_s);
    StampDecision& farther = lidar_farther ? by_lidar : by_imu;
    StampDecision& nearer = lidar_farther ? by_imu : by_lidar;
    farther = {StampRule::kRecord, reason};
    if (std::min(std::abs(*lidar_s), std::abs(*imu_s)) > kClockSplitS) nearer = farther;
  } else if (by_lidar.rule != by_imu.rule && lidar_s && imu_s) {
    // One uses record time: the other may keep its headers only if they agree with the recorder.
    const bool lidar_keeps = by_lidar.rule == StampRule::kHeader;
    const double kept_s = std::abs(lidar_keeps ? *lidar_s : *imu_s);
    if (kept_s > kClockSplitS) {
      (lidar_keeps ? by_lidar : by_imu) = {
          StampRule::kRecord,
          fmt::format("stamps are {:.1f} s from the recorder's clock, which the other sensor needs",
                      kept_s)};
    }
  }
  // Both sensors use a clock other than the recorder's: stamps of the recorder are moved to it.
  if (by_lidar.rule == StampRule::kHeader && lidar_s && std::abs(*lidar_s) > kClockSplitS) {
    probe.clock_ahead = Duration::from_s(*lidar_s);
  }
  probe.lidar_stamps = by_lidar.rule;
  probe.imu_stamps = by_imu.rule;
  if (by_lidar.rule == StampRule::kRecord) {
    report.lidar_stamp = "record";
    stamp_finding(report, probe.topics.lidar, by_lidar.reason);
  }
  if (by_imu.rule == StampRule::kRecord) {
    report.imu_stamp = "record";
    stamp_finding(report, probe.topics.imu, by_imu.reason);
  }
}

std::vector<Time> times_of(std::span<const StampPair> stamps, StampRule rule) {
  std::vector<Time> times;
  for (const StampPair& pair : stamps) {
    times.push_back(rule == StampRule::kRecord ? pair.record : pair.header);
  }
  return times;
}

/// Drops unusable inertial data as a whole: an odometry that waits for them or trusts the few it
/// gets is worse than LiDAR alone.
void leave_unfit_imu(std::span<const StampPair> lidar, std::span<const StampPair> imu,
                     RecordingProbe& probe, InputReport& report) {
  const std::optional<std::string> why =
      unfit_inertial(times_of(lidar, probe.lidar_stamps), times_of(imu, probe.imu_stamps));
  if (!why) return;
  Finding f;
  f.id = "D10";
  f.vehicle = report.vehicle;
  f.topic = probe.topics.imu;
  f.text = *why + ": mapped with LiDAR alone";
  f.effect = "Gravity and fast turns come from the LiDAR only.";
  f.remedy = "Record the IMU with the LiDAR at 100 Hz or more; see rali doctor.";
  report.findings.push_back(std::move(f));
  report.gaps.damaged = true;
  report.has_imu = false;
  report.imu_topic.clear();
  probe.topics.imu.clear();
}

TfTree first_tf(const RecordingProbe& probe) {
  TfTree tree;
  for (const StoredMessage& m : probe.messages) {
    if (m.kind != wire::MessageKind::kTf) continue;
    const Result<wire::TfMessage> tf = wire::decode_tf(m.data, m.encoding);
    if (!tf) continue;
    for (const wire::TransformStamped& transform : tf->transforms) tree.add(transform);
  }
  return tree;
}

void add_findings(const FindingList& from, InputReport& report, const std::string& topic) {
  for (Finding f : from) {
    f.vehicle = report.vehicle;
    if (f.topic.empty()) f.topic = topic;
    report.findings.push_back(std::move(f));
  }
}

}  // namespace

Result<RecordingProbe> decide_probe(std::deque<StoredMessage> messages,
                                    std::span<const TopicCount> topics, const std::string& file,
                                    const InputOptions& options, InputReport& report) {
  RecordingProbe probe;
  probe.messages = std::move(messages);
  Result<TopicChoice> choice = choose_topics(topics, options, file);
  if (!choice) return tl::make_unexpected(choice.error());
  probe.topics = *choice;
  report.lidar_topic = choice->lidar;
  report.imu_topic = choice->imu;

  const std::vector<wire::CloudView> views = first_views(probe);
  if (views.empty()) {
    return fail(ErrorCode::kInput, file + ": " + probe.topics.lidar,
                "no whole cloud can be read near its beginning", "Is the file cut? See rali info.");
  }
  Result<wire::CloudFormat> format = wire::decide_cloud_format(views, options.cloud);
  if (!format) {
    Error error = format.error();
    error.code = ErrorCode::kInput;
    error.where =
        file + ": " + probe.topics.lidar + (error.where.empty() ? "" : ": " + error.where);
    return tl::make_unexpected(std::move(error));
  }
  probe.format = std::move(*format);
  report.cloud_format = probe.format;
  report.lidar_frame = views.front().frame_id;
  add_findings(probe.format.findings, report, report.lidar_topic);

  const FirstImu imu = first_imu(probe, report);
  report.has_imu = !probe.topics.imu.empty();
  Result<ImuUnits> units = decide_imu_units(imu.samples, options, report.imu_topic);
  if (!units) {
    Error error = units.error();
    error.where = file + ": " + error.where;
    return tl::make_unexpected(std::move(error));
  }
  probe.units = *units;
  report.accel_scale = units->accel_scale;
  report.gyro_scale = units->gyro_scale;
  add_findings(units->findings, report, report.imu_topic);

  const std::vector<StampPair> scan_stamps = lidar_stamps(probe, options.cloud);
  choose_stamps(probe, scan_stamps, imu.stamps, report);
  leave_unfit_imu(scan_stamps, imu.stamps, probe, report);
  const std::vector<sensor::LidarScan> scans = first_scans(views, probe.format, options.cloud);
  if (Status status =
          decide_extrinsics(options, first_tf(probe), scans, imu.samples, probe.units, report);
      !status) {
    return tl::make_unexpected(status.error());
  }
  return probe;
}

Result<RecordingProbe> probe_recording(RecordingChain& chain, const InputOptions& options,
                                       InputReport& report) {
  RecordingProbe read;
  std::vector<TopicCount> topics;
  read_first(chain, read, topics, report);
  return decide_probe(std::move(read.messages), topics, chain.paths().front(), options, report);
}

}  // namespace rali::drive
