#include <utility>

#include "rali/drive/internal/map_run_stages.hpp"
#include "rali/drive/offset/clock_pass.hpp"
#include "rali/drive/offset/time_offset.hpp"
#include "rali/drive/open_events.hpp"

namespace rali::drive::internal {

/// For a pass over one vehicle's data: shows its progress; false once the run shall stop. May be
/// called from several threads.
std::function<bool(double)> MapRun::progress_of(const std::string& vehicle,
                                                const std::string& stage) {
  Progress progress;
  progress.vehicle = vehicle;
  progress.stage = stage;
  return [this, progress](double fraction) mutable {
    const std::lock_guard lock(reporting_);  // the sink is not thread-safe
    progress.fraction = fraction;
    sink_.progress(progress);
    return !stop_.load(std::memory_order_relaxed);
  };
}

/// Opens a vehicle's source once more, with what was found.
Status MapRun::open_again(std::size_t index, VehicleJob job) {
  job.input.turning_follows = false;
  Result<std::unique_ptr<ReportedSource>> source = open_events(job);
  if (!source) return tl::make_unexpected(source.error());
  sources_[index] = std::move(*source);
  return {};
}

namespace {

/// R_imu_lidar as given or assumed: what the ground proposed in place of nothing is no assumption.
geometry::Mat3 assumed_rotation(const InputReport& input) {
  const bool given =
      input.T_body_lidar_origin != "ground" && input.T_body_lidar_origin != "assumed zero";
  const geometry::Mat3 R_imu_body = input.T_body_imu.R.transpose();
  return given ? geometry::Mat3(R_imu_body * input.T_body_lidar.R) : R_imu_body;
}

}  // namespace

/// Estimates the requested time offsets and judges the mountings by the turning of LiDAR and IMU,
/// for all vehicles in parallel.
Status MapRun::study_turning() {
  std::vector<std::size_t> asked;
  for (std::size_t i = 0; i < sources_.size() && !job_.facts; ++i) {
    const InputReport& input = sources_[i]->report();
    const bool wanted = job_.vehicles[i].find_time_offset || input.mounting_in_question;
    if (wanted && input.has_imu) asked.push_back(i);
  }
  std::vector<VehicleJob> jobs;
  jobs.reserve(asked.size());
  for (const std::size_t i : asked) jobs.push_back(member_job(job_, i, ranges_));
  executor_->for_blocks(asked.size(), 1, [&](std::size_t k, std::size_t, std::size_t) {
    InputOptions& input = jobs[k].input;
    const Turning turning =
        study_turning_of(jobs[k], assumed_rotation(sources_[asked[k]]->report()), *executor_,
                         threads_ > 1, progress_of(input.vehicle, "time offset"));
    if (jobs[k].find_time_offset) input.lidar_time_offset = turning.offset;
    input.mounting = turning.mounting;
  });
  for (std::size_t k = 0; k < asked.size(); ++k) {
    if (Status s = open_again(asked[k], jobs[k]); !s) return s;
    if (!jobs[k].find_time_offset) continue;
    report(time_offset_finding(jobs[k].input.lidar_time_offset, sources_[asked[k]]->report()));
  }
  return {};
}

/// A vehicle's job with what its turning has shown.
VehicleJob MapRun::found_so_far(std::size_t index) const {
  VehicleJob job = member_job(job_, index, ranges_);
  job.input.lidar_time_offset = sources_[index]->report().lidar_time_offset;
  job.input.mounting = sources_[index]->report().mounting;
  return job;
}

/// What each vehicle's clock needs, as far as it is known by now.
std::vector<double> MapRun::clock_offsets_s() const {
  std::vector<double> offsets_s;
  for (const VehicleJob& vehicle : job_.vehicles) {
    offsets_s.push_back(vehicle.input.clock_offset.value_s);
  }
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    offsets_s[i] = sources_[i]->report().clock_offset.value_s;
  }
  return offsets_s;
}

/// Plays all recordings through their odometry, in parallel, and compares their motion with the
/// ranges that other clocks have stamped.
std::vector<ClockOffset> MapRun::estimate_clock_offsets() {
  std::vector<ClockPass> passes(job_.vehicles.size());
  executor_->for_blocks(passes.size(), 1, [&](std::size_t i, std::size_t, std::size_t) {
    VehicleJob job = found_so_far(i);
    passes[i] = play_for_clock(job, *executor_, threads_ > 1,
                               progress_of(job.input.vehicle, "clock offset"));
    passes[i].evidence.known = job_.vehicles[i].clock_offset_given;
  });
  std::vector<sensor::RangeSample> ranges = range_list_.samples;
  std::vector<ClockEvidence> evidence;
  for (ClockPass& pass : passes) {
    evidence.push_back(std::move(pass.evidence));
    ranges.insert(ranges.end(), pass.ranges.begin(), pass.ranges.end());
  }
  ClockSearch search;
  search.latency_known = job_.ranges.latency_s.has_value();
  return judge_clock_offsets(evidence, ranges, search);
}

/// Estimates the clocks of the vehicles and opens their sources once more with the results.
Status MapRun::find_clock_offsets() {
  const std::vector<ClockOffset> offsets = estimate_clock_offsets();
  for (std::size_t i = 1; i < sources_.size(); ++i) {
    if (job_.vehicles[i].clock_offset_given) continue;
    VehicleJob job = found_so_far(i);
    job.input.clock_offset = offsets[i];
    if (Status status = open_again(i, job); !status) return status;
    report(
        clock_offset_finding(job.input.vehicle, job_.vehicles.front().input.vehicle, offsets[i]));
  }
  // Their findings were reported when they were read first.
  Result<RangeList> ranges = read_range_files(job_.ranges, clock_offsets_s());
  if (!ranges) return tl::make_unexpected(ranges.error());
  range_list_.samples = std::move(ranges->samples);
  return {};
}

/// Whether the clocks agree, as the user has said: the ranges are compared with the motion as it
/// was published. A quick look, since it is seldom needed.
void MapRun::check_clocks() {
  if (!job_.known.common_clock || job_.find_clock_offsets || runs_.size() < 2) return;
  std::vector<ClockEvidence> evidence;
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    ClockEvidence& vehicle = evidence.emplace_back();
    vehicle.antennas_body_m = job_.vehicles[i].settings.antennas_body_m;
    for (const PoseRecord& pose : runs_[i].poses()) {
      vehicle.add(pose.t, pose.T_odom_body, pose.quality, pose.degenerate);
    }
  }
  std::vector<sensor::RangeSample> ranges;
  for (const ranging::RangeUse* use : range_log_.in_order()) ranges.push_back(use->sample);
  ClockSearch search;
  search.half_s = 2.0;
  search.windows_max = 6;
  search.ranges_max = 80;
  search.latency_known = job_.ranges.latency_s.has_value();
  const std::vector<ClockOffset> offsets = judge_clock_offsets(evidence, ranges, search);
  for (std::size_t i = 1; i < offsets.size(); ++i) {
    auto other = other_clock_finding(job_.vehicles[i].input.vehicle,
                                     job_.vehicles.front().input.vehicle, offsets[i]);
    if (other) report(std::move(*other));
  }
}

}  // namespace rali::drive::internal
