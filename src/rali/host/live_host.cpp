#include "rali/host/live_host.hpp"

#include <thread>
#include <utility>

#include <fmt/format.h>

#include "rali/host/internal/live_host_impl.hpp"
#include "rali/net/seen_counters.hpp"

// Work of the caller's thread: agent, fleet link and view.
namespace rali::host {
namespace {

constexpr Duration kLinkWait = Duration::from_ns(5'000'000);
constexpr double kTick_s = 0.1, kSecond_s = 1.0;
constexpr std::uint64_t kDiskLow_bytes = 1U << 30, kDiskFull_bytes = 64U << 20;

}  // namespace

void LiveHost::Impl::note(Finding finding, HostListener& listener) {
  finding.vehicle = vehicle_;
  listener.finding(finding);
}

void LiveHost::Impl::hand_out(HostListener& listener) {
  for (AgentOutput& output : out_.agent) {
    if (auto* send = std::get_if<SendBytes>(&output)) {
      if (parts_.link == nullptr) continue;
      // Refused: facts are requested again, other messages are repeated. The link counts it.
      static_cast<void>(parts_.link->send(send->to, send->urgency, as_octets_of(send->bytes)));
    } else if (auto* save = std::get_if<fleet::SaveRole>(&output)) {
      if (parts_.state != nullptr) to_disk_.put(std::move(*save));
    } else if (auto* fact = std::get_if<fleet::SaveFact>(&output)) {
      if (parts_.state != nullptr) to_disk_.put(std::move(*fact));
    } else if (auto* job = std::get_if<fleet::RunJob>(&output)) {
      JobWorker& worker = fleet::explores(job->kind) ? explorations_ : estimates_;
      worker.run(job->number, std::move(job->job));
    } else if (const auto* cancelled = std::get_if<fleet::CancelJob>(&output)) {
      for (JobWorker* worker : {&estimates_, &explorations_}) worker->cancel(cancelled->number);
    } else if (auto* finding = std::get_if<Finding>(&output)) {
      note(std::move(*finding), listener);
    }
  }
  if (out_.picture) pictures_.run(0, std::move(out_.picture));
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
  take_jobs(now);
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

void LiveHost::Impl::take_jobs(HostTime now) {
  for (JobWorker* worker : {&estimates_, &explorations_}) {
    for (const fleet::JobDone& done : worker->take()) fleet_.take(done, now, out_);
  }
  for (const fleet::JobDone& done : pictures_.take()) {
    fleet_.take_picture(done.job.get(), now, out_);
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
                        to_record_.refused() + to_poses_.refused() + from_serial_.refused();
  return facts;
}

void LiveHost::Impl::each_second(HostTime now, HostListener& listener) {
  if (parts_.link != nullptr && parts_.state != nullptr) {
    seen_to_disk_.put(net::encode_seen(parts_.link->seen()));
  }
  const HostFacts host = facts(now);
  if (host.queue_refused > refused_reported_) {
    note(finding_of("live.queue_full", Severity::kError,
                    fmt::format("{} values did not fit into a queue between threads",
                                host.queue_refused - refused_reported_),
                    "", "Give the program more of the computer."),
         listener);
    refused_reported_ = host.queue_refused;
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
  std::thread disk, record, poses, serial;
  if (parts_.state != nullptr) {
    // The first second is reported before anything is written.
    disk_free_.store(parts_.state->free_bytes(), std::memory_order_relaxed);
    disk = std::thread([&] { disk_loop(end); });
  }
  if (parts_.record != nullptr) record = std::thread([&] { record_loop(end); });
  if (parts_.poses != nullptr) poses = std::thread([&] { poses_loop(end); });
  if (parts_.serial != nullptr) serial = std::thread([&] { serial_loop(end); });
  std::thread sensors([&] { sensor_loop(stop); });
  while (!stop.load(std::memory_order_relaxed)) fleet_step(listener);
  sensors.join();
  fleet_step(listener);  // last outputs of the odometry, and its facts for the disk
  end.store(true, std::memory_order_release);
  for (std::thread* thread : {&disk, &record, &poses, &serial}) {
    if (thread->joinable()) thread->join();
  }
  for (Finding& finding : findings_.take()) note(std::move(finding), listener);
  each_second(host_now(), listener);
  const bool recorded = parts_.record != nullptr && !record_failed_;
  Status status = recorded ? parts_.record->finish() : Status{};
  if (status) status = poses_status_;
  return {status, fleet_.sensors().scans, last_state_};
}

LiveHost::LiveHost(LiveHostSetup setup, const LiveHostParts& parts, Executor& executor)
    : impl_(std::make_unique<Impl>(std::move(setup), parts, executor)) {}

LiveHost::~LiveHost() = default;

LiveHostEnd LiveHost::run(HostListener& listener, const std::atomic<bool>& stop) {
  return impl_->run(listener, stop);
}

}  // namespace rali::host