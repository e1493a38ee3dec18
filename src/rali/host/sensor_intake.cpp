#include "rali/host/sensor_intake.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "rali/drive/ranges/linktrack_samples.hpp"
#include "rali/drive/ranges/range_files.hpp"
#include "rali/host/sensor_topics.hpp"
#include "rali/wire/message_kind.hpp"

namespace rali::host {
namespace {

constexpr double kSettle_s = 2.0;
constexpr std::size_t kRecent = 64;
/// Time span of the messages used for a rate.
constexpr double kRateSpan_s = 3.0;

std::string name_of_kind(wire::MessageKind kind) {
  if (wire::is_cloud(kind)) return "lidar";
  if (kind == wire::MessageKind::kImu) return "imu";
  return kind == wire::MessageKind::kTf ? "tf_static" : "uwb";
}

std::string listed_topics(std::span<const net::RosTopic> topics) {
  std::string text;
  for (const net::RosTopic& topic : topics) text += topic.name + ' ' + topic.type + '\n';
  return text;
}

}  // namespace

/// Drops impossible ranges.
class SensorIntake::Judge final : public drive::EventSink {
 public:
  Judge(LiveOrder& order, const drive::RangeOptions& ranges) : order_(order), ranges_(ranges) {}

  void push(const sensor::ImuSample& sample) override { order_.push(sample); }

  void push(std::shared_ptr<const sensor::LidarScan> scan) override {
    order_.push(std::move(scan));
  }

  void push(const sensor::RangeSample& sample) override {
    if (drive::judge_range(sample, ranges_) == ranging::RangeReason::kNoPose) order_.push(sample);
  }

 private:
  LiveOrder& order_;
  const drive::RangeOptions& ranges_;
};

SensorIntake::SensorIntake(IntakeSetup setup)
    : setup_(std::move(setup)),
      ranges_(std::make_shared<drive::RangeOptions>(setup_.ranges)),
      order_(setup_.order, setup_.ranges.exchange),
      judge_(std::make_unique<Judge>(order_, *ranges_)),
      serial_stamps_(std::make_unique<drive::RadioStamps>(setup_.ranges.arrival)),
      waits_for_("waits for topics of sensors.") {
  setup_.input.ranges = ranges_;
  report_.vehicle = setup_.input.vehicle;
}

SensorIntake::~SensorIntake() = default;

std::vector<net::RosTopic> SensorIntake::choose(std::span<const net::RosTopic> published,
                                                Time now) {
  std::vector<net::RosTopic> wanted;
  if (!has_sensors_) {
    const Result<SensorTopics> sensors = choose_sensors(published, setup_.input, setup_.fleet);
    if (!sensors) {
      waits_for_ = "waits for sensors: " + sensors.error().message();
      candidates_.clear();
    } else {
      if (const std::string seen = listed_topics(published); seen != candidates_) {
        candidates_ = seen;
        t_candidates_ = now;
      }
      waits_for_ = "waits for the topics of sensors to stay the same.";
      if (seconds_between(*t_candidates_, now) >= kSettle_s) {
        has_sensors_ = true;
        waits_for_ = fmt::format("waits for the first messages of {}{}.", sensors->lidar.name,
                                 sensors->imu ? " and " + sensors->imu->name : "");
        wanted.push_back(sensors->lidar);
        if (sensors->imu) wanted.push_back(*sensors->imu);
        wanted.insert(wanted.end(), sensors->transforms.begin(), sensors->transforms.end());
      }
    }
  }
  for (const net::RosTopic& topic :
       range_topics(published, setup_.ranges, setup_.input.vehicle, setup_.fleet)) {
    if (ranges_->topic_of(topic.name) == nullptr) {
      drive::RangeTopic found;
      found.topic = topic.name;
      if (!setup_.ranges.serial_logs.empty()) found.ids = setup_.ranges.serial_logs.front().ids;
      ranges_->topics.push_back(std::move(found));
    }
    wanted.push_back(topic);
  }
  std::erase_if(wanted, [this](const net::RosTopic& topic) {
    return std::find(chosen_.begin(), chosen_.end(), topic.name) != chosen_.end();
  });
  for (const net::RosTopic& topic : wanted) chosen_.push_back(topic.name);
  return wanted;
}

void SensorIntake::watch(const std::string& name, const std::string& topic, Time t) {
  Watch& watch = watches_[topic];
  watch.name = name;
  ++watch.messages;
  watch.t_last = t;
  watch.recent.push_back(t);
  while (watch.recent.size() > kRecent || seconds_between(watch.recent.front(), t) > kRateSpan_s) {
    watch.recent.pop_front();
  }
}

void SensorIntake::take(const net::RosTopic& topic, Time t_arrival,
                        std::span<const std::byte> message) {
  drive::RecordedMessage m;
  m.kind = wire::message_kind(topic.type);
  m.topic = topic.name;
  m.type = topic.type;
  m.encoding = wire::Encoding::kCdr;
  m.t_record = t_arrival;
  m.data = message;
  watch(name_of_kind(m.kind), topic.name, t_arrival);
  if (reader_) return read(m);
  store(m);
  const bool enough = first_clouds_ >= drive::kProbeClouds &&
                      seconds_between(first_.front().t_record, t_arrival) >= drive::kProbe_s;
  if (enough || first_bytes_ > drive::kProbeBytes) decide();
}

void SensorIntake::store(const drive::RecordedMessage& m) {
  first_bytes_ += m.data.size();
  if (wire::is_cloud(m.kind)) ++first_clouds_;
  first_.push_back({m.kind,
                    std::string(m.topic),
                    std::string(m.type),
                    m.encoding,
                    m.t_record,
                    {m.data.begin(), m.data.end()},
                    0,
                    0});
}

/// Unreadable input is examined again with the next seconds: a driver may be restarted.
void SensorIntake::decide() {
  std::map<std::string, drive::TopicCount> counts;
  for (const drive::StoredMessage& m : first_) {
    drive::TopicCount& count = counts[m.topic];
    count.name = m.topic;
    count.type = m.type;
    count.kind = m.kind;
    ++count.messages;
  }
  std::vector<drive::TopicCount> topics;
  for (auto& [name, count] : counts) topics.push_back(std::move(count));
  drive::InputReport report;
  report.vehicle = setup_.input.vehicle;
  report.lidar_time_offset = setup_.input.lidar_time_offset;
  report.clock_offset = setup_.input.clock_offset;
  Result<drive::RecordingProbe> probe =
      drive::decide_probe(std::move(first_), topics, "live", setup_.input, report);
  first_.clear();
  first_bytes_ = first_clouds_ = 0;
  if (!probe) {
    waits_for_ = "waits for sensors that can be used: " + probe.error().message();
    return;
  }
  waits_for_.clear();
  report_ = std::move(report);
  reader_ = std::make_unique<drive::MessageReader>(
      *probe, setup_.input, [](const drive::RecordedMessage&) { return std::string(); });
  for (const drive::StoredMessage& m : probe->messages) {
    read({m.kind, m.topic, m.type, m.encoding, m.t_record, m.data, m.offset, m.file});
  }
}

void SensorIntake::read(const drive::RecordedMessage& message) {
  order_.set_arrival(message.t_record);
  reader_->take(message, *judge_, report_);
  order_.take(message.t_record, events_);
}

void SensorIntake::take_serial(Time t_arrival, std::span<const std::byte> bytes) {
  serial_.push(bytes);
  std::vector<sensor::RangeSample> samples;
  while (const auto frame = serial_.next()) {
    watch("uwb", "serial port", t_arrival);
    const bool by_arrival = ranges_->stamp == drive::RangeStamp::kRecord;
    const Time t = by_arrival ? t_arrival : serial_stamps_->host_time(*frame, t_arrival);
    const auto ids = setup_.ranges.serial_logs.empty() ? std::map<std::int64_t, io::RadioEnd>{}
                                                       : setup_.ranges.serial_logs.front().ids;
    drive::append_linktrack(*frame, t - ranges_->latency(), ids, setup_.input.self, samples);
  }
  if (!reader_) return;
  order_.set_arrival(t_arrival);
  for (const sensor::RangeSample& sample : samples) judge_->push(sample);
}

void SensorIntake::take_events(Time now, std::vector<LiveEvent>& out) {
  out.insert(out.end(), std::make_move_iterator(events_.begin()),
             std::make_move_iterator(events_.end()));
  events_.clear();
  order_.take(now, out);
}

std::vector<SensorHealth> SensorIntake::health() const {
  std::vector<SensorHealth> all;
  for (const auto& [topic, watch] : watches_) {
    SensorHealth health{watch.name, topic, watch.messages, watch.t_last, 0.0};
    if (watch.recent.size() >= 2) {
      const double span_s = seconds_between(watch.recent.front(), watch.recent.back());
      if (span_s > 0.0) health.rate_hz = static_cast<double>(watch.recent.size() - 1) / span_s;
    }
    all.push_back(std::move(health));
  }
  return all;
}

FindingList SensorIntake::take_findings() {
  FindingList news(report_.findings.begin() + static_cast<std::ptrdiff_t>(findings_reported_),
                   report_.findings.end());
  findings_reported_ = report_.findings.size();
  return news;
}

}  // namespace rali::host
