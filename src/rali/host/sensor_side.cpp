#include "rali/host/sensor_side.hpp"

#include <utility>

#include "rali/drive/member_job.hpp"

namespace rali::host {
namespace {

using LiveScan = std::shared_ptr<const sensor::LidarScan>;

Time stamp_of_event(const vehicle::Event& event) {
  if (const auto* imu = std::get_if<sensor::ImuSample>(&event)) return imu->t;
  if (const auto* scan = std::get_if<LiveScan>(&event)) return (*scan)->t_end;
  if (const auto* range = std::get_if<sensor::RangeSample>(&event)) return range->t;
  return {};
}

}  // namespace

SensorSide::SensorSide(SensorSideSetup setup, Executor& executor)
    : setup_(std::move(setup)),
      executor_(executor),
      intake_(setup_.intake),
      outputs_(setup_.intake.input.vehicle) {}

void SensorSide::take(const ToSensors& news) {
  if (const auto* frame = std::get_if<FrameNews>(&news)) {
    T_map_local_ = frame->T_map_local;
  } else if (vehicle_) {
    step_out_.clear();
    vehicle_->step(std::get<fleet::PeerStatus>(news), executor_, step_out_);
  }
}

/// Starts the vehicle with the first messages: the mounting is not known earlier.
void SensorSide::start_vehicle(const LiveEvent& first, const Publish& publish,
                               std::vector<ToAgent>& news) {
  const vehicle::VehicleSettings settings = drive::settings_with(setup_.vehicle, intake_.report());
  vehicle_ = std::make_unique<vehicle::Vehicle>(setup_.self, settings);
  const Time t = stamp_of_event(first.event);
  publish(outputs_.mounting(settings.calibration, t));
  news.emplace_back(ClockNews{t - first.arrival});
}

void SensorSide::run(const std::function<Time()>& now, const Publish& publish,
                     std::vector<ToAgent>& news) {
  map_poses_.clear();
  if (!intake_.decided()) return;
  events_.clear();
  intake_.take_events(now(), events_);
  for (const LiveEvent& next : events_) {
    if (!vehicle_) {
      start_vehicle(next, publish, news);
      t_started_ = now();
    }
    if (std::holds_alternative<LiveScan>(next.event)) scan_arrival_ = next.arrival;
    const Time before = now();
    const std::uint64_t scans = scans_;
    step(next.event, publish, news);
    if (scans_ == scans) continue;
    const Time after = now();
    scan_step_.add(seconds_between(before, after));
    const bool live = scan_arrival_ && *scan_arrival_ > t_started_;
    if (live) latency_.add(seconds_between(*scan_arrival_, after));
  }
}

void SensorSide::step(const vehicle::Event& event, const Publish& publish,
                      std::vector<ToAgent>& news) {
  if (const auto* range = std::get_if<sensor::RangeSample>(&event)) {
    news.emplace_back(RangeNews{*range});
    if (const auto out = outputs_.range(*range, setup_.intake.fleet)) publish(*out);
  }
  step_out_.clear();
  vehicle_->step(event, executor_, step_out_);
  for (vehicle::Output& output : step_out_) {
    if (const auto* pose = std::get_if<vehicle::PoseEstimate>(&output)) {
      ++scans_;
      messages_.clear();
      outputs_.pose(*pose, T_map_local_, messages_);
      for (const RosOut& message : messages_) publish(message);
      if (T_map_local_) map_poses_.push_back({pose->t, *T_map_local_ * pose->T_local_body});
    }
    // The agent receives keyframes as facts, thinned.
    if (std::holds_alternative<vehicle::KeyframeAdded>(output)) continue;
    news.emplace_back(VehicleNews{std::move(output)});
  }
}

void SensorSide::finish(const Publish& publish, std::vector<ToAgent>& news) {
  map_poses_.clear();
  if (vehicle_) step(vehicle::EndOfData{}, publish, news);
}

SensorNews SensorSide::sensor_news() const {
  SensorNews news;
  news.decided = intake_.decided();
  news.waits_for = intake_.waits_for();
  news.sensors = intake_.health();
  news.order = intake_.order_tally();
  news.gaps = intake_.report().gaps;
  news.latency_p50_s = latency_.quantile_s(0.5);
  news.latency_p99_s = latency_.quantile_s(0.99);
  news.latency_max_s = latency_.max_s();
  news.scan_step_p50_s = scan_step_.quantile_s(0.5);
  news.scan_step_p99_s = scan_step_.quantile_s(0.99);
  news.scans = scans_;
  return news;
}

}  // namespace rali::host
