#include "rali/drive/recording_events.hpp"

#include <utility>

#include <fmt/format.h>

#include "rali/drive/input/event_outlet.hpp"
#include "rali/drive/input/imu_intake.hpp"
#include "rali/drive/input/recording_probe.hpp"
#include "rali/drive/ranges/range_topics.hpp"
#include "rali/wire/decode.hpp"

namespace rali::drive {
namespace {

/// Damaged messages named one by one before only the count goes on.
constexpr std::uint64_t kNamedErrors = 5;

class RecordingEvents final : public ReportedSource {
 public:
  RecordingEvents(RecordingChain chain, RecordingProbe probe, InputOptions options,
                  InputReport report)
      : chain_(std::move(chain)),
        probe_(std::move(probe)),
        options_(std::move(options)),
        report_(std::move(report)),
        lidar_stamps_(probe_.lidar_stamps, shifts_),
        imu_stamps_(probe_.imu_stamps, shifts_),
        intake_(probe_.units),
        range_topics_(options_.ranges, options_.self, probe_.clock_ahead),
        outlet_(options_) {}

  Result<std::optional<vehicle::Event>> next() override {
    while (!ended_) {
      std::optional<vehicle::Event> event = outlet_.pop(report_);
      if (event) return event;
      if (exhausted_ || outlet_.past_end()) {
        end();
      } else if (!read_one() || (options_.strict && report_.gaps.damaged)) {
        exhausted_ = true;
        outlet_.finish();
      }
    }
    return std::optional<vehicle::Event>();
  }

  double progress() const override { return ended_ ? 1.0 : chain_.progress(); }

  const InputReport& report() const override { return report_; }

 private:
  bool read_one() {
    if (!probe_.messages.empty()) {
      const StoredMessage stored = std::move(probe_.messages.front());
      probe_.messages.pop_front();
      handle({stored.kind, stored.topic, stored.type, stored.encoding, stored.t_record, stored.data,
              stored.offset, stored.file});
      return true;
    }
    RecordedMessage message;
    if (!chain_.next(message, report_.gaps, report_.findings)) return false;
    handle(message);
    return true;
  }

  void handle(const RecordedMessage& message) {
    if (message.file != file_) {
      file_ = message.file;
      lidar_stamps_.begin_file(chain_.clock_was_set(message.file));
      imu_stamps_.begin_file(chain_.clock_was_set(message.file));
    }
    if (message.topic == probe_.topics.lidar && wire::is_cloud(message.kind)) {
      handle_cloud(message);
    } else if (message.topic == probe_.topics.imu && message.kind == wire::MessageKind::kImu) {
      handle_imu(message);
    } else if (range_topics_.wants(message)) {
      handle_ranges(message);
    }
  }

  void handle_ranges(const RecordedMessage& message) {
    ++report_.range_messages[std::string(message.topic)];
    ranges_.clear();
    if (Status s = range_topics_.take(message, ranges_); !s) return damaged(message, s.error());
    for (const sensor::RangeSample& sample : ranges_) outlet_.push(sample);
  }

  void handle_cloud(const RecordedMessage& message) {
    const Result<wire::CloudView> view =
        wire::decode_cloud_message(message.kind, message.data, message.encoding);
    if (!view) return damaged(message, view.error());
    auto scan = std::make_shared<sensor::LidarScan>();
    if (Status s = wire::decode_cloud(*view, probe_.format, options_.cloud, *scan); !s) {
      return damaged(message, s.error());
    }
    if (scan->size() == 0) return outlet_.push(std::move(scan));
    const std::optional<Time> t_end =
        repair(lidar_stamps_, {scan->t_end, message.t_record}, message);
    if (!t_end) return;
    const Duration shift{(*t_end - scan->t_end).ns +
                         Duration::from_s(options_.lidar_time_offset.value_s).ns};
    scan->t_begin = scan->t_begin + shift;
    scan->t_end = scan->t_end + shift;
    outlet_.push(std::move(scan));
  }

  void handle_imu(const RecordedMessage& message) {
    Result<wire::ImuMessage> imu = wire::decode_imu(message.data, message.encoding);
    if (!imu) return damaged(message, imu.error());
    const std::optional<Time> t = repair(imu_stamps_, {imu->sample.t, message.t_record}, message);
    if (!t) return;
    imu->sample.t = *t;
    if (const auto sample = intake_.take(imu->sample, report_.gaps)) outlet_.push(*sample);
  }

  std::optional<Time> repair(StampRepair& repair, StampPair stamps,
                             const RecordedMessage& message) {
    const std::uint64_t jumps = repair.jumps();
    const std::optional<Time> t = repair.repair(stamps);
    report_.gaps.repeated = lidar_stamps_.repeats() + imu_stamps_.repeats();
    report_.gaps.jumps = lidar_stamps_.jumps() + imu_stamps_.jumps();
    if (repair.jumps() == jumps || repair.jumps() > kNamedErrors) return t;
    Finding f;
    f.id = "D04";
    f.vehicle = report_.vehicle;
    f.topic = message.topic;
    f.t = t.value_or(Time{});
    f.text = fmt::format("{}:offset {}: stamps of {} jump by {:+.3f} s; the jump is closed",
                         chain_.paths()[message.file], message.offset, message.topic,
                         repair.last_jump_s());
    f.value = repair.last_jump_s();
    report_.findings.push_back(std::move(f));
    return t;
  }

  void damaged(const RecordedMessage& message, const Error& error) {
    report_.gaps.damaged = true;
    if (++report_.gaps.undecodable > kNamedErrors) return;
    Finding f;
    f.id = "D19";
    f.vehicle = report_.vehicle;
    f.topic = message.topic;
    f.text = fmt::format("{}:offset {}: message of {} left out: {}", chain_.paths()[message.file],
                         message.offset, message.topic, error.message());
    report_.findings.push_back(std::move(f));
  }

  void end() {
    ended_ = true;
    outlet_.close(report_);
  }

  RecordingChain chain_;
  RecordingProbe probe_;
  InputOptions options_;
  InputReport report_;
  std::shared_ptr<ClockShifts> shifts_ = std::make_shared<ClockShifts>();
  StampRepair lidar_stamps_, imu_stamps_;
  ImuIntake intake_;
  RangeTopics range_topics_;
  std::vector<sensor::RangeSample> ranges_;  ///< of one message
  EventOutlet outlet_;
  std::optional<std::size_t> file_;  ///< of the last message
  bool exhausted_ = false, ended_ = false;
};

}  // namespace

Result<std::unique_ptr<ReportedSource>> open_recording_events(const std::vector<std::string>& paths,
                                                              const InputOptions& options) {
  Result<RecordingChain> chain = RecordingChain::open(paths, options);
  if (!chain) return tl::make_unexpected(chain.error());
  InputReport report;
  report.vehicle = options.vehicle;
  report.files = paths;
  report.lidar_time_offset = options.lidar_time_offset;
  Result<RecordingProbe> probe = probe_recording(*chain, options, report);
  if (!probe) return tl::make_unexpected(probe.error());
  return std::make_unique<RecordingEvents>(std::move(*chain), std::move(*probe), options,
                                           std::move(report));
}

}  // namespace rali::drive
