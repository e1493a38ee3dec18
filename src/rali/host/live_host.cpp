#include "rali/host/live_host.hpp"

#include <array>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "rali/host/bounded_queue.hpp"
#include "rali/host/fleet_state.hpp"
#include "rali/host/host_clock.hpp"
#include "rali/host/job_worker.hpp"
#include "rali/host/view_outputs.hpp"
#include "rali/net/wall_clock.hpp"

namespace rali::host {
namespace {

constexpr Duration kTakeWait = Duration::from_ns(5'000'000);
constexpr Duration kLinkWait = Duration::from_ns(5'000'000);
constexpr Duration kDiskWait = Duration::from_ns(100'000'000);
constexpr double kTick_s = 0.1, kSecond_s = 1.0, kTopics_s = 0.5, kSensorNews_s = 0.2;
constexpr std::size_t kNewsMax = 50'000, kOutboxMax = 1000, kDiskMax = 100'000;
constexpr std::size_t kRecordMax = 4000;
constexpr std::uint64_t kDiskLow_bytes = 1U << 30, kDiskFull_bytes = 64U << 20;

std::span<const std::byte> as_message(const std::vector<std::uint8_t>& bytes) {
  return std::as_bytes(std::span(bytes));
}

std::span<const std::uint8_t> as_octets_of(const wire::Bytes& bytes) {
  return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}

Finding host_finding(std::string id, Severity severity, std::string text, std::string remedy) {
  Finding finding;
  finding.id = std::move(id);
  finding.severity = severity;
  finding.text = std::move(text);
  finding.remedy = std::move(remedy);
  return finding;
}

/// A raw message on its way to the recording.
struct Recorded {
  net::RosTopic topic;
  Time t;
  std::vector<std::uint8_t> cdr;
};

}  // namespace

class LiveHost::Impl {
 public:
  Impl(LiveHostSetup setup, const LiveHostParts& parts, Executor& executor)
      : setup_(std::move(setup)),
        parts_(parts),
        vehicle_(setup_.fleet.agent.names[setup_.fleet.agent.self.value]),
        sensors_(setup_.sensors, executor),
        fleet_(std::move(setup_.fleet), host_now()) {
    if (parts_.view != nullptr) view_ = std::make_unique<ViewOutputs>(*parts_.view, vehicle_);
  }

  LiveHostEnd run(HostListener& listener, const std::atomic<bool>& stop);

 private:
  // The thread of sensors and odometry.
  [[nodiscard]] Status advertise();
  void take_goal_status(const net::RosMessage& message, std::vector<ToAgent>& news);
  void sensor_loop(const std::atomic<bool>& stop);
  void look_for_topics(HostTime now);
  void publish(const RosOut& message);
  void send_news(std::vector<ToAgent>& news);
  void drain_outbox();

  // Those of the disk, the recording and the serial port.
  void disk_loop(const std::atomic<bool>& end);
  void record_loop(const std::atomic<bool>& end);
  void serial_loop(const std::atomic<bool>& end);

  // The caller's.
  void fleet_step(HostListener& listener);
  void hand_out(HostListener& listener);
  void each_second(HostTime now, HostListener& listener);
  [[nodiscard]] HostFacts facts(HostTime now);
  void note(Finding finding, HostListener& listener);

  LiveHostSetup setup_;
  LiveHostParts parts_;
  std::string vehicle_;
  SensorSide sensors_;
  FleetSide fleet_;
  std::unique_ptr<ViewOutputs> view_;

  std::array<int, kRosTopics> publications_{};
  std::map<int, net::RosTopic> subscriptions_;
  int goal_status_ = -1;  ///< subscription
  std::optional<Time> next_topics_, next_sensor_news_;

  BoundedQueue<ToAgent> to_agent_{kNewsMax};
  BoundedQueue<ToSensors> to_sensors_{kOutboxMax};
  BoundedQueue<RosOut> outbox_{kOutboxMax}, to_view_{kOutboxMax};
  BoundedQueue<fleet::NodeOutput> to_disk_{kDiskMax};
  BoundedQueue<fleet::NodeEvent> from_disk_{kDiskMax};
  BoundedQueue<Finding> findings_{kOutboxMax};
  BoundedQueue<Recorded> to_record_{kRecordMax};
  BoundedQueue<net::SerialBytes> from_serial_{kOutboxMax};
  std::atomic<int> viewers_{0};
  std::atomic<bool> record_failed_{false};
  std::atomic<std::uint64_t> disk_free_{0}, disk_waiting_{0};

  JobWorker jobs_{std::make_unique<SerialExecutor>()};
  FleetSideOutputs out_;
  DurationStats steps_;
  std::optional<Time> next_tick_, next_second_, t_rates_;
  std::map<VehicleId, std::uint64_t> bytes_before_;
  std::uint64_t refused_told_ = 0;
  LiveState last_state_;
};

// The thread of sensors and odometry.

Status LiveHost::Impl::advertise() {
  for (std::size_t i = 0; i < kRosTopics; ++i) {
    const Result<int> id = parts_.bus->advertise(ros_topic(static_cast<RosTopicId>(i), vehicle_));
    if (!id) return tl::make_unexpected(id.error());
    publications_[i] = *id;
  }
  const std::string status = "/" + ros_name(vehicle_) + "/navigate_to_pose/_action/status";
  const Result<int> id =
      parts_.bus->subscribe({status, std::string(wire::kGoalStatusType), {true, true, 1}});
  if (!id) return tl::make_unexpected(id.error());
  goal_status_ = *id;
  return {};
}

/// What cannot be read is left out: the motion shows how a drive goes, too.
void LiveHost::Impl::take_goal_status(const net::RosMessage& message, std::vector<ToAgent>& news) {
  auto status = wire::decode_goal_status(as_message(message.cdr));
  if (status) news.emplace_back(GoalNews{std::move(*status)});
}

void LiveHost::Impl::publish(const RosOut& message) {
  parts_.bus->publish(publications_[static_cast<std::size_t>(message.topic)],
                      as_octets_of(message.cdr));
  if (viewers_.load(std::memory_order_relaxed) > 0) to_view_.put(message);
}

void LiveHost::Impl::send_news(std::vector<ToAgent>& news) {
  for (ToAgent& item : news) to_agent_.put(std::move(item));
  news.clear();
}

void LiveHost::Impl::drain_outbox() {
  for (const RosOut& message : outbox_.take()) {
    parts_.bus->publish(publications_[static_cast<std::size_t>(message.topic)],
                        as_octets_of(message.cdr));
  }
}

void LiveHost::Impl::look_for_topics(HostTime now) {
  if (next_topics_ && now.boot < *next_topics_) return;
  next_topics_ = now.boot + Duration::from_s(kTopics_s);
  for (const net::RosTopic& topic : sensors_.intake().choose(parts_.bus->published(), now.boot)) {
    const Result<int> id = parts_.bus->subscribe(topic);
    if (id) {
      subscriptions_[*id] = topic;
    } else {
      findings_.put(host_finding("live.subscribe", Severity::kError, id.error().message(), ""));
    }
  }
}

void LiveHost::Impl::sensor_loop(const std::atomic<bool>& stop) {
  std::vector<ToAgent> news;
  const auto wall = [] { return net::wall_now(); };
  const Publish send = [this](const RosOut& message) { publish(message); };
  while (!stop.load(std::memory_order_relaxed)) {
    for (net::RosMessage& message : parts_.bus->take(kTakeWait)) {
      if (message.subscription == goal_status_) take_goal_status(message, news);
      const auto topic = subscriptions_.find(message.subscription);
      if (topic == subscriptions_.end()) continue;
      sensors_.intake().take(topic->second, message.t, as_message(message.cdr));
      if (parts_.record != nullptr) {
        to_record_.put({topic->second, message.t, std::move(message.cdr)});
      }
    }
    for (const net::SerialBytes& bytes : from_serial_.take()) {
      sensors_.intake().take_serial(bytes.t, bytes.bytes);
    }
    for (const ToSensors& item : to_sensors_.take()) sensors_.take(item);
    sensors_.run(wall, send, news);
    const HostTime now = host_now();
    look_for_topics(now);
    for (Finding& finding : sensors_.intake().take_findings()) findings_.put(std::move(finding));
    if (!next_sensor_news_ || now.boot >= *next_sensor_news_) {
      next_sensor_news_ = now.boot + Duration::from_s(kSensorNews_s);
      news.emplace_back(sensors_.sensor_news());
    }
    send_news(news);
    drain_outbox();
  }
  sensors_.finish(send, news);
  news.emplace_back(sensors_.sensor_news());
  send_news(news);
  drain_outbox();
}

// Those of the disk, the recording and the serial port.

void LiveHost::Impl::disk_loop(const std::atomic<bool>& end) {
  const auto write = [this](bool all) {
    for (const fleet::NodeOutput& output : to_disk_.take(all ? Duration{} : kDiskWait)) {
      parts_.state->take(output);
    }
    for (fleet::NodeEvent& event : parts_.state->sync(host_now().boot, all)) {
      from_disk_.put(std::move(event));
    }
    for (Finding& finding : parts_.state->take_findings()) findings_.put(std::move(finding));
    disk_free_.store(parts_.state->free_bytes(), std::memory_order_relaxed);
    disk_waiting_.store(parts_.state->waiting(), std::memory_order_relaxed);
  };
  while (!end.load(std::memory_order_acquire)) write(false);
  write(true);
}

void LiveHost::Impl::record_loop(const std::atomic<bool>& end) {
  const auto write = [this](Duration wait) {
    for (const Recorded& message : to_record_.take(wait)) {
      if (record_failed_.load(std::memory_order_relaxed)) continue;
      const Status status = parts_.record->write(message.topic, message.t, as_message(message.cdr));
      if (status) continue;
      record_failed_.store(true, std::memory_order_relaxed);
      findings_.put(host_finding("live.recording", Severity::kError,
                                 "the recording ends here: " + status.error().message(),
                                 "Free space, and start again with another folder."));
    }
  };
  while (!end.load(std::memory_order_acquire)) write(kDiskWait);
  write({});
}

/// The vehicle goes on without its radio; a plug that is put back is found again.
void LiveHost::Impl::serial_loop(const std::atomic<bool>& end) {
  bool told = false;
  while (!end.load(std::memory_order_acquire)) {
    Result<net::SerialBytes> bytes = parts_.serial->read(kDiskWait);
    if (bytes) {
      if (!bytes->bytes.empty()) from_serial_.put(std::move(*bytes));
      continue;
    }
    if (!std::exchange(told, true)) {
      findings_.put(host_finding("live.serial_port", Severity::kError, bytes.error().message(),
                                 "Plug the radio in and start rali run again."));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
  }
}

// The caller's.

void LiveHost::Impl::note(Finding finding, HostListener& listener) {
  finding.vehicle = vehicle_;
  listener.finding(finding);
}

void LiveHost::Impl::hand_out(HostListener& listener) {
  for (AgentOutput& output : out_.agent) {
    if (auto* send = std::get_if<SendBytes>(&output)) {
      if (parts_.link == nullptr) continue;
      // Refused: facts are asked for again, the rest is said again. The link counts it.
      static_cast<void>(parts_.link->send(send->to, send->urgency, as_octets_of(send->bytes)));
    } else if (auto* save = std::get_if<fleet::SaveRole>(&output)) {
      if (parts_.state != nullptr) to_disk_.put(std::move(*save));
    } else if (auto* fact = std::get_if<fleet::SaveFact>(&output)) {
      if (parts_.state != nullptr) to_disk_.put(std::move(*fact));
    } else if (auto* job = std::get_if<fleet::RunJob>(&output)) {
      jobs_.run(std::move(*job));
    } else if (const auto* cancelled = std::get_if<fleet::CancelJob>(&output)) {
      jobs_.cancel(cancelled->number);
    } else if (auto* finding = std::get_if<Finding>(&output)) {
      note(std::move(*finding), listener);
    }
  }
  for (ToSensors& item : out_.sensors) to_sensors_.put(std::move(item));
  for (RosOut& message : out_.publish) {
    if (view_) view_->publish(message);
    outbox_.put(std::move(message));
  }
  if (view_) {
    for (const std::string& json : out_.paths) {
      view_->publish_paths(fleet_.agent_time(host_now()), json);
    }
  }
  out_ = {};
}

void LiveHost::Impl::fleet_step(HostListener& listener) {
  if (parts_.link != nullptr) parts_.link->wait(kLinkWait);
  std::vector<ToAgent> news = to_agent_.take(parts_.link == nullptr ? kLinkWait : Duration{});
  const HostTime now = host_now();
  for (ToAgent& item : news) fleet_.take(std::move(item), now, out_);
  if (parts_.link != nullptr) {
    for (const net::Arrived& arrived : parts_.link->take()) {
      fleet_.receive(arrived.from, as_message(arrived.bytes), now, out_);
    }
  }
  for (const fleet::NodeEvent& event : from_disk_.take()) fleet_.take(event, now, out_);
  for (const fleet::JobDone& done : jobs_.take()) fleet_.take(done, now, out_);
  if (!next_tick_ || now.boot >= *next_tick_) {
    next_tick_ = now.boot + Duration::from_s(kTick_s);
    fleet_.tick(now, out_);
  }
  hand_out(listener);
  steps_.add(seconds_between(now.boot, host_now().boot));
  for (Finding& finding : findings_.take()) note(std::move(finding), listener);
  if (view_) {
    for (const RosOut& message : to_view_.take()) view_->publish(message);
    viewers_.store(parts_.view->viewers(), std::memory_order_relaxed);
    for (const view::OperatorRequest& request : parts_.view->take_requests()) {
      fleet_.take(request, now, out_);
    }
  }
  if (!next_second_ || now.boot >= *next_second_) {
    next_second_ = now.boot + Duration::from_s(kSecond_s);
    each_second(now, listener);
  }
}

HostFacts LiveHost::Impl::facts(HostTime now) {
  HostFacts facts;
  facts.epoch = setup_.epoch;
  facts.has_link = parts_.link != nullptr;
  if (parts_.link != nullptr) facts.links = parts_.link->counts();
  const double span_s = t_rates_ ? seconds_between(*t_rates_, now.boot) : 0.0;
  for (const net::LinkCounts& link : facts.links) {
    const std::uint64_t before = bytes_before_[link.peer];
    if (span_s > 0.0) {
      facts.rates_Bps[link.peer] = static_cast<double>(link.arrived_bytes - before) / span_s;
    }
    bytes_before_[link.peer] = link.arrived_bytes;
  }
  t_rates_ = now.boot;
  if (parts_.state != nullptr) {
    StateDisk disk;
    disk.free_bytes = disk_free_.load(std::memory_order_relaxed);
    if (disk.free_bytes < kDiskFull_bytes) {
      disk.state = "full";
      disk.message = "No more points of keyframes are kept.";
    } else if (disk.free_bytes < kDiskLow_bytes) {
      disk.state = "low";
      disk.message = "Little is left for the state.";
    }
    facts.disk = disk;
    facts.unsynced_facts = disk_waiting_.load(std::memory_order_relaxed);
  }
  facts.step_p50_s = steps_.quantile_s(0.5);
  facts.step_p99_s = steps_.quantile_s(0.99);
  facts.step_max_s = steps_.max_s();
  facts.queue = to_agent_.size();
  facts.queue_max = to_agent_.largest();
  facts.queue_refused = to_agent_.refused() + outbox_.refused() + to_disk_.refused() +
                        to_record_.refused() + from_serial_.refused();
  return facts;
}

void LiveHost::Impl::each_second(HostTime now, HostListener& listener) {
  const HostFacts host = facts(now);
  if (host.queue_refused > refused_told_) {
    note(host_finding("live.queue_full", Severity::kError,
                      fmt::format("{} values did not fit into a queue between threads",
                                  host.queue_refused - refused_told_),
                      "Give the program more of the computer."),
         listener);
    refused_told_ = host.queue_refused;
  }
  last_state_ = live_state(fleet_, host, now);
  fleet_.publish_diagnostics(last_state_.diagnostics, now, out_);
  hand_out(listener);
  if (view_) view_->publish(last_state_);
  listener.state(last_state_);
}

LiveHostEnd LiveHost::Impl::run(HostListener& listener, const std::atomic<bool>& stop) {
  if (Status status = advertise(); !status) return {status, 0, {}};
  std::atomic<bool> end{false};
  std::thread disk, record, serial;
  if (parts_.state != nullptr) disk = std::thread([&] { disk_loop(end); });
  if (parts_.record != nullptr) record = std::thread([&] { record_loop(end); });
  if (parts_.serial != nullptr) serial = std::thread([&] { serial_loop(end); });
  std::thread sensors([&] { sensor_loop(stop); });
  while (!stop.load(std::memory_order_relaxed)) fleet_step(listener);
  sensors.join();
  fleet_step(listener);  // what the odometry finished, and its facts to the disk
  end.store(true, std::memory_order_release);
  for (std::thread* thread : {&disk, &record, &serial}) {
    if (thread->joinable()) thread->join();
  }
  for (Finding& finding : findings_.take()) note(std::move(finding), listener);
  each_second(host_now(), listener);
  const bool recorded = parts_.record != nullptr && !record_failed_;
  return {recorded ? parts_.record->finish() : Status{}, fleet_.sensors().scans, last_state_};
}

LiveHost::LiveHost(LiveHostSetup setup, const LiveHostParts& parts, Executor& executor)
    : impl_(std::make_unique<Impl>(std::move(setup), parts, executor)) {}

LiveHost::~LiveHost() = default;

LiveHostEnd LiveHost::run(HostListener& listener, const std::atomic<bool>& stop) {
  return impl_->run(listener, stop);
}

}  // namespace rali::host
