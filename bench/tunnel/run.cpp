#include "run.hpp"

#include <cmath>
#include <numbers>

#include "common/cpu_time.hpp"
#include "common/vehicle_settings.hpp"
#include "rali/base/rng.hpp"
#include "rali/fleet/path/level.hpp"
#include "rali/vehicle/vehicle.hpp"

namespace rali::tunnel {

using geometry::SE3;
using geometry::Vec3;

namespace {

constexpr double kStatus_s = 0.1;  // a vehicle reports its standstill ten times a second
constexpr double kPriorSigma_m = 0.2;
constexpr double kPriorSigma_rad = 3.0 * std::numbers::pi / 180.0;

/// Upright, with the heading of the body.
SE3 levelled(const SE3& T_world_body) {
  return fleet::level_start(T_world_body, geometry::Vec3::UnitZ());
}

/// As measured by tape and compass: with errors drawn from its sigmas.
vehicle::PeerPrior prior_of(const RecordingHead& head, std::uint64_t seed) {
  Rng rng(seed, "prior");
  vehicle::PeerPrior prior;
  prior.sigma_m = kPriorSigma_m;
  prior.sigma_rad = kPriorSigma_rad;
  SE3 turned;
  turned.R = geometry::rotation_from_rpy(0.0, 0.0, kPriorSigma_rad * rng.normal());
  prior.T_self_peer =
      turned * (levelled(head.T_world_self).inverse() * levelled(head.T_world_peer));
  for (int axis = 0; axis < 3; ++axis) {
    prior.T_self_peer.p[axis] += kPriorSigma_m * rng.normal();
  }
  return prior;
}

/// Feeds the vehicle and collects its outputs.
class Driver {
 public:
  Driver(const Row& row, std::uint64_t seed, vehicle::VehicleSettings settings)
      : row_(row), seed_(seed), settings_(std::move(settings)) {}

  void start(const RecordingHead& head) {
    settings_.calibration = head.calibration;
    settings_.antennas_body_m = {head.own_antenna_m};
    vehicle::PeerSettings peer;
    peer.id = VehicleId{kAnchor};
    peer.name = "v1";
    peer.antennas_body_m = {head.peer_antenna_m};
    if (row_.on.prior) peer.prior = prior_of(head, seed_);
    settings_.peers = {peer};
    vehicle_.emplace(VehicleId{kDriver}, settings_);
    track_.t_start = head.t_start;
    track_.path_m = head.path_m;
    const double middle_s = 0.5 * seconds_between(head.t_start, head.t_end);
    track_.loss_start = head.t_start + Duration::from_s(middle_s - 0.5 * row_.on.loss_s);
    track_.loss_end = head.t_start + Duration::from_s(middle_s + 0.5 * row_.on.loss_s);
  }

  void take(const sensor::ImuSample& imu) {
    if (row_.ranges && imu.t >= next_status_ && !is_lost(imu.t)) {
      next_status_ = imu.t + Duration::from_s(kStatus_s);
      step(vehicle::PeerStatus{VehicleId{kAnchor}, imu.t, true});
    }
    step(imu);
  }

  void take(std::shared_ptr<const sensor::LidarScan> scan, const eval::StampedPose& truth) {
    track_.truth.push_back(truth);
    step(std::move(scan));
  }

  void take(const sensor::RangeSample& sample, const sim::RangeTruth& truth) {
    if (!row_.ranges || is_lost(sample.t)) return;
    track_.received.push_back(sample.t);
    error_m_[sample.t.ns] = sample.range_m - truth.distance_m - truth.bias_m;
    step(sample);
  }

  Track finish() {
    step(vehicle::EndOfData{});
    track_.smoothed = track_.live;
    drive::correct_path(corrections_, track_.smoothed, track_.keyframes);
    return std::move(track_);
  }

 private:
  [[nodiscard]] bool is_lost(Time t) const {
    return row_.on.loss_s > 0.0 && t >= track_.loss_start && t < track_.loss_end;
  }

  void step(const vehicle::Event& event) {
    out_.clear();
    const double begin = bench::cpu_ms();
    vehicle_->step(event, executor_, out_);
    spent_ms_ += bench::cpu_ms() - begin;
    for (const vehicle::Output& output : out_) take_output(output);
  }

  void take_output(const vehicle::Output& output) {
    if (const auto* pose = std::get_if<vehicle::PoseEstimate>(&output)) {
      track_.live.push_back(drive::pose_record(*pose));
      track_.cpu_ms.push_back(spent_ms_);
      spent_ms_ = 0.0;
      track_.diverged += pose->quality == vehicle::PoseQuality::kDiverged ? 1 : 0;
    } else if (const auto* added = std::get_if<vehicle::KeyframeAdded>(&output)) {
      take_keyframe(*added);
    } else if (const auto* corrected = std::get_if<vehicle::KeyframeCorrected>(&output)) {
      corrections_[corrected->id.seq] = *corrected;
    } else if (const auto* use = std::get_if<ranging::RangeUse>(&output)) {
      const auto error = error_m_.find(use->sample.t.ns);
      track_.ranges.push_back({*use, error == error_m_.end() ? 0.0 : error->second});
    } else if (const auto* finding = std::get_if<Finding>(&output)) {
      track_.findings.push_back(*finding);
    }
  }

  void take_keyframe(const vehicle::KeyframeAdded& added) {
    if (!added.keyframe) return;
    drive::KeyframeRecord record;
    record.id = added.id;
    record.t = added.keyframe->t;
    record.T_local_body = added.keyframe->T_odom_body;
    record.covariance = added.keyframe->covariance;
    record.T_body_lidar = added.keyframe->T_body_lidar;
    record.points = added.keyframe->cloud.size();
    track_.keyframes.push_back(record);
    if (row_.mesh) track_.clouds.push_back({added.id, added.keyframe});
  }

  const Row& row_;
  std::uint64_t seed_;
  vehicle::VehicleSettings settings_;
  std::optional<vehicle::Vehicle> vehicle_;
  SerialExecutor executor_;
  vehicle::OutputList out_;
  drive::KeyframeCorrections corrections_;
  std::map<std::int64_t, double> error_m_;  ///< by stamp
  Track track_;
  Time next_status_ = Time::from_ns(0);
  double spent_ms_ = 0.0;
};

}  // namespace

Status check_settings(const std::vector<std::string>& settings) {
  if (const auto checked = bench::vehicle_settings(settings); !checked) {
    return tl::make_unexpected(checked.error());
  }
  return {};
}

Result<Track> run(const Recording& recording, const Row& row,
                  const std::vector<std::string>& settings) {
  std::vector<std::string> all = settings;
  all.insert(all.end(), row.settings.begin(), row.settings.end());
  auto made = bench::vehicle_settings(all);
  if (!made) return tl::make_unexpected(made.error());
  const std::uint64_t seed = recording.place().seed;
  Driver driver(row, seed, std::move(*made));
  Listener listener;
  listener.on_head = [&](const RecordingHead& head) { driver.start(head); };
  listener.on_imu = [&](const sensor::ImuSample& imu) { driver.take(imu); };
  listener.on_scan = [&](std::shared_ptr<const sensor::LidarScan> scan,
                         const eval::StampedPose& truth) { driver.take(std::move(scan), truth); };
  listener.on_range = [&](const sensor::RangeSample& sample, const sim::RangeTruth& truth) {
    driver.take(sample, truth);
  };
  const sim::UwbOptions uwb = radios(seed, row.on.burst_fraction);
  if (auto ok = recording.play(uwb, listener); !ok) return tl::make_unexpected(ok.error());
  return driver.finish();
}

}  // namespace rali::tunnel
