#include "rali/inspect/examination.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "rali/base/counted.hpp"
#include "rali/inspect/ground_normal.hpp"
#include "rali/inspect/imu_study.hpp"
#include "rali/inspect/make_finding.hpp"
#include "rali/inspect/rotation_findings.hpp"
#include "rali/inspect/stamp_study.hpp"

namespace rali::inspect {
namespace {

constexpr std::size_t kFirstClouds = 10;
constexpr std::size_t kImuMax = 4'000'000;
constexpr std::size_t kStampsMax = 4'000'000;
/// Fewer scans do not suffice to evaluate LiDAR odometry.
constexpr std::uint64_t kScansMin = 20;

}  // namespace

Examination::Examination(const DoctorOptions& options, Executor& executor)
    : options_(options), executor_(executor) {}

void Examination::add_cloud(std::vector<std::byte> message, wire::CloudView view, Time t_record) {
  if (cloud_stamps_.size() < kStampsMax) cloud_stamps_.push_back({view.stamp, t_record});
  if (format_) return decode(view);
  if (!format_error_.empty()) return;
  waiting_.push_back({std::move(message), std::move(view)});
  if (waiting_.size() >= kFirstClouds) decide_format();
}

void Examination::add_undecodable(const std::string& topic, const std::string& reason) {
  if (undecodable_++ > 0) return;
  undecodable_topic_ = topic;
  undecodable_reason_ = reason;
}

void Examination::add_imu(const sensor::ImuSample& raw, Time t_record) {
  if (imu_.size() >= kImuMax) return;
  imu_.push_back(raw);
  imu_stamps_.push_back({raw.t, t_record});
}

void Examination::decide_format() {
  std::vector<wire::CloudView> views;
  for (const Waiting& w : waiting_) views.push_back(w.view);
  Result<wire::CloudFormat> format = wire::decide_cloud_format(views, options_.cloud);
  if (format) {
    format_ = std::move(*format);
    for (const Waiting& w : waiting_) decode(w.view);
  } else {
    format_error_ = format.error().what;
    format_remedy_ = format.error().remedy;
  }
  waiting_.clear();
}

void Examination::decode(const wire::CloudView& view) {
  const Status status = wire::decode_cloud(view, *format_, options_.cloud, scan_);
  if (!status) return add_undecodable("", status.error().message());
  clouds_.add(scan_, std::size_t{view.width} * view.height);
  track(scan_);
}

void Examination::track(const sensor::LidarScan& scan) {
  if (scan.size() > 0 && !up_lidar_) up_lidar_ = ground_normal(scan);
  turning_.see(scan, executor_);
}

void Examination::judge_rates(const DoctorReport& report, FindingList& out) const {
  const StampStatistics lidar = study_stamps(cloud_stamps_), imu = study_stamps(imu_stamps_);
  if (lidar.messages > 0) {
    report_rate(lidar, "D01", "scans", report.lidar_topic, out);
    report_stamps(lidar, report.lidar_topic, out);
  }
  if (imu.messages > 0) {
    report_rate(imu, "D10", "inertial samples", report.imu_topic, out);
    report_stamps(imu, report.imu_topic, out);
    report_clock_split(lidar, imu, report.imu_topic, out);
    if (imu.batch_fraction > 0.3) {
      out.push_back(make_finding(
          "D10", Severity::kInfo, report.imu_topic,
          {fmt::format("{:.0f} % of the samples arrive in batches; stamps are used, not arrivals",
                       100.0 * imu.batch_fraction),
           "", ""},
          {imu.batch_fraction, 0.3}));
    }
  }
  if (undecodable_ == 0) return;
  out.push_back(make_finding("D19", Severity::kWarning, undecodable_topic_,
                             {fmt::format("{} cannot be read, the first: {}",
                                          counted(undecodable_, "message"), undecodable_reason_),
                              "they are left out", ""},
                             {static_cast<double>(undecodable_), 0.0}));
}

void Examination::judge_rotations(DoctorReport& report, FindingList& out) {
  std::stable_sort(imu_.begin(), imu_.end(),
                   [](const auto& a, const auto& b) { return a.t < b.t; });
  report.rotations = imu::study_rotations(turning_.turns(), imu_);
  const imu::RotationStudy& study = report.rotations;
  std::optional<double> gyro_scale;
  if (study.gyro_ratio > 10.0)
    gyro_scale = 1.0 / 57.29577951308232;
  else if (study.gyro_ratio > 0.0)
    gyro_scale = 1.0;
  const ImuStudy imu = study_imu(imu_, study_stamps(imu_stamps_).period_s, gyro_scale,
                                 report.imu_topic, out, options_.T_body_imu.R);
  report.accel_scale = imu.accel_scale;
  report.gyro_scale = imu.gyro_scale;
  ExtrinsicsGiven given;
  if (report.T_body_lidar) given.R_body_lidar = report.T_body_lidar->R;
  given.R_body_imu = options_.T_body_imu.R;
  given.origin = options_.T_body_lidar ? "settings" : "/tf_static";
  report_gyro_unit(study, turning_.degenerate_fraction(), report.imu_topic, out);
  report_time_offset(study, report.lidar_topic, out);
  report_extrinsics(study, given, turning_.turns(), imu_, out);
  if (imu.units_known) {
    report_up(up_lidar_, imu.up_imu, study, given, report.lidar_topic, out);
  }
}

void Examination::finish(DoctorReport& report) {
  if (!format_ && format_error_.empty() && !waiting_.empty()) decide_format();
  FindingList& out = report.findings;
  judge_rates(report, out);
  if (!format_error_.empty()) {
    out.push_back(make_finding("D01", Severity::kError, report.lidar_topic,
                               {format_error_, "the clouds cannot be read", format_remedy_}));
  }
  clouds_.report(format_.value_or(wire::CloudFormat{}), report.lidar_topic, out);
  report.format = format_;
  if (!cloud_stamps_.empty()) {
    report.t_start = cloud_stamps_.front().header;
    report.t_end = cloud_stamps_.back().header;
  }
  report.track = turning_.track();
  if (turning_.scans() > kScansMin && turning_.lost() * 10 > turning_.scans()) {
    const double fraction =
        static_cast<double>(turning_.lost()) / static_cast<double>(turning_.scans());
    out.push_back(make_finding(
        "D18", Severity::kWarning, report.lidar_topic,
        {fmt::format("LiDAR alone loses the pose in {:.0f} % of the scans", 100.0 * fraction),
         "inertial data and ranges must constrain the pose there", ""},
        {fraction, 0.1}));
  }
  if (!imu_.empty()) {
    judge_rotations(report, out);
  } else {
    out.push_back(
        make_finding("D10", Severity::kWarning, "",
                     {"no inertial data: mapping with LiDAR alone",
                      "degenerate directions are constrained by ranges only, gravity is not known",
                      "Record the IMU with the LiDAR."}));
  }
}

}  // namespace rali::inspect
