#include "rali/drive/offset/time_offset.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "rali/drive/offset/lidar_turning.hpp"
#include "rali/drive/open_events.hpp"
#include "rali/drive/read_ahead.hpp"

namespace rali::drive {
namespace {

/// Data before the first result, between results, and at most [s of data].
constexpr double kFirst_s = 20.0, kStep_s = 10.0, kMax_s = 60.0;
/// Four of these are kOffsetMin_s: more data would hardly change the decision.
constexpr double kCertain_s = 0.0025;
/// Of a vehicle that shakes, or in dust, LiDAR alone loses track: more data would not help.
constexpr double kLostMax_ratio = 0.2;
/// A gyro at 3 kHz over kMax_s; a faster one ends the search early.
constexpr std::size_t kImuMax = 200'000;
constexpr double kDegPerRad = 180.0 / std::numbers::pi;
/// After two full turns a large sigma has another reason than too little turning.
constexpr double kEnough_rad = 4.0 * std::numbers::pi;

/// Half the points of a map: the shape of the turns limits the offset's accuracy, not the noise of
/// each. A scan that LiDAR alone would have to search contributes no turn.
odometry::OdometrySettings turning_settings() {
  odometry::OdometrySettings settings;
  settings.robust.sampling.update_points /= 2;
  settings.robust.sampling.insert_points /= 2;
  settings.robust.search.wide = false;
  return settings;
}

bool is_certain(const imu::RotationStudy& study) {
  return study.time_offset_s && study.time_offset_sigma_s <= kCertain_s;
}

/// Collects the rotation of both sensors while the first events pass.
class Search {
 public:
  Search(EventSource& events, Executor& executor, double max_s, const geometry::Mat3& assumed)
      : events_(events), executor_(executor), max_s_(max_s), R_imu_lidar_assumed_(assumed) {}

  Turning run(const std::function<bool(double)>& go_on) {
    double next_answer_s = kFirst_s;
    while (imu_.size() < kImuMax) {
      if (!go_on(std::clamp(looked_at_s() / max_s_, 0.0, 1.0))) {
        return {{0.0, {}, {}, "not estimated: the run was stopped"}, {}};
      }
      const auto event = events_.next();
      if (!event || !*event) break;
      take(**event);
      if (looked_at_s() < next_answer_s) continue;
      next_answer_s += kStep_s;
      const imu::RotationStudy study = imu::study_rotations(lidar_.turns(), imu_);
      if (is_certain(study)) return judged(study);
      const double lost_ratio =
          static_cast<double>(lidar_.lost()) / static_cast<double>(lidar_.scans());
      if (lost_ratio > kLostMax_ratio) {
        return {{0.0,
                 {},
                 {},
                 fmt::format("not estimated: LiDAR alone lost track in {:.0f} % of the scans",
                             100.0 * lost_ratio)},
                {}};
      }
    }
    return judged(imu::study_rotations(lidar_.turns(), imu_));
  }

 private:
  [[nodiscard]] Turning judged(const imu::RotationStudy& study) const {
    return {judge_time_offset(study, looked_at_s()),
            imu::judge_mounting(R_imu_lidar_assumed_, lidar_.turns(), imu_, study)};
  }

  void take(const vehicle::Event& event) {
    if (const auto* sample = std::get_if<sensor::ImuSample>(&event)) {
      imu_.push_back(*sample);
      see(sample->t);
    } else if (const auto* scan = std::get_if<std::shared_ptr<const sensor::LidarScan>>(&event)) {
      lidar_.see(**scan, executor_);
      see((*scan)->t_end);
    }
  }

  void see(Time t) {
    if (!t_first_) t_first_ = t;
    t_last_ = t;
  }

  [[nodiscard]] double looked_at_s() const {
    return t_first_ ? seconds_between(*t_first_, t_last_) : 0.0;
  }

  EventSource& events_;
  Executor& executor_;
  double max_s_;
  geometry::Mat3 R_imu_lidar_assumed_;
  LidarTurning lidar_{turning_settings()};
  std::vector<sensor::ImuSample> imu_;
  std::optional<Time> t_first_;
  Time t_last_;
};

}  // namespace

LidarTimeOffset judge_time_offset(const imu::RotationStudy& study, double looked_at_s) {
  LidarTimeOffset out;
  if (study.offset_at_border) {
    out.origin = "not estimated: no offset within 0.3 s makes LiDAR and gyro turn alike";
    return out;
  }
  if (!study.time_offset_s || study.time_offset_sigma_s > kOffsetSigmaMax_s) {
    const std::string turned = fmt::format("{:.0f} deg of turning in {:.0f} s",
                                           study.turned_rad * kDegPerRad, looked_at_s);
    out.origin = study.turned_rad > kEnough_rad && study.time_offset_sigma_s > 0.0
                     ? fmt::format("not estimated: sigma {:.0f} ms after {}",
                                   1e3 * study.time_offset_sigma_s, turned)
                     : fmt::format("not estimated: {} are too little", turned);
    return out;
  }
  out.estimate_s = *study.time_offset_s;
  out.sigma_s = study.time_offset_sigma_s;
  const double limit_s = std::max(kOffsetMin_s, 4.0 * *out.sigma_s);
  const bool significant = std::abs(*out.estimate_s) > limit_s;
  if (significant) out.value_s = std::round(*out.estimate_s * 1e4) * 1e-4;
  out.origin = fmt::format("{:+.1f} ms by turning, sigma {:.1f} ms{}", 1e3 * *out.estimate_s,
                           1e3 * *out.sigma_s, significant ? "" : ": not significant");
  return out;
}

Turning study_turning_of(const VehicleJob& job, const geometry::Mat3& R_imu_lidar_assumed,
                         Executor& executor, bool read_ahead,
                         const std::function<bool(double fraction)>& go_on) {
  VehicleJob beginning = job;
  beginning.input.lidar_time_offset = {};
  beginning.input.extrinsics = ExtrinsicsCheck::kOff;  // the rotation study needs no extrinsics
  double& duration_s = beginning.input.duration_s;
  duration_s = duration_s > 0.0 ? std::min(duration_s, kMax_s) : kMax_s;
  const auto source = open_events(beginning);
  if (!source) return {{0.0, {}, {}, "not estimated: the input cannot be read"}, {}};
  if (!read_ahead) return Search(**source, executor, duration_s, R_imu_lidar_assumed).run(go_on);
  ReadAhead ahead(**source);
  return Search(ahead, executor, duration_s, R_imu_lidar_assumed).run(go_on);
}

Finding time_offset_finding(const LidarTimeOffset& offset, const InputReport& report) {
  Finding f;
  f.id = "D12";
  f.vehicle = report.vehicle;
  f.topic = report.lidar_topic;
  f.value = offset.estimate_s.value_or(0.0);
  f.limit = std::max(kOffsetMin_s, 4.0 * offset.sigma_s.value_or(0.0));
  const bool applied = offset.value_s != 0.0;
  f.severity = applied ? Severity::kWarning : Severity::kInfo;
  f.text = fmt::format("time offset of the LiDAR's stamps: {:+.4f} s {} ({})", offset.value_s,
                       applied ? "added" : "taken", offset.origin);
  if (applied) {
    f.remedy = fmt::format("Synchronise the clocks, or keep it by lidar.time_offset_s: {:.4f}.",
                           offset.value_s);
  }
  return f;
}

}  // namespace rali::drive
