#include "rali/drive/vehicle_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>
#include <variant>

#include "rali/vehicle/odom_frame.hpp"

namespace rali::drive {
namespace {

/// Without a gravity estimate odom is assumed to be level.
const geometry::Vec3 kDown_mps2(0.0, 0.0, -9.80665);

/// A scan with less rotation does not count for the ratio of gyro and LiDAR.
constexpr double kTurnMin_rad = 0.01;

/// Interval of the poses that are compared with the final ones.
constexpr double kTrackStep_s = 0.5;

void keep(Time t, const geometry::SE3& T, const geometry::Mat6& covariance,
          std::vector<monitor::StatedPose>& track) {
  if (!track.empty() && seconds_between(track.back().t, t) < kTrackStep_s) return;
  track.push_back({t, T, covariance.bottomRightCorner<3, 3>()});
}

}  // namespace

geometry::SE3 level_frame(const geometry::Vec3& g_odom_mps2, const geometry::SE3& T_odom_first) {
  const geometry::Mat3 R_level =
      g_odom_mps2.norm() > 0.0 && g_odom_mps2.allFinite()
          ? geometry::rotation_between(g_odom_mps2, -geometry::Vec3::UnitZ())
          : geometry::Mat3::Identity();
  const geometry::Mat3 R_first = R_level * T_odom_first.R;
  const double yaw_rad = std::atan2(R_first(1, 0), R_first(0, 0));
  geometry::SE3 T_map_local;
  T_map_local.R = geometry::rotation_from_rpy(0.0, 0.0, -yaw_rad) * R_level;
  T_map_local.p = -(T_map_local.R * T_odom_first.p);
  return T_map_local;
}

Result<VehicleRun> VehicleRun::start(const std::string& name, const std::string& out_dir,
                                     SessionFile* session) {
  Result<PoseFiles> odometry = PoseFiles::create(out_dir, "odometry", name, "odom/" + name);
  if (!odometry) return tl::make_unexpected(odometry.error());
  Result<LiveFiles> live = LiveFiles::create(out_dir, name);
  if (!live) return tl::make_unexpected(live.error());
  VehicleRun run(name, out_dir, session);
  run.odometry_ = std::move(*odometry);
  run.live_ = std::move(*live);
  return run;
}

VehicleRun VehicleRun::of_facts(const std::string& name, const std::string& out_dir,
                                SessionFile* session) {
  return {name, out_dir, session};
}

VehicleRun::VehicleRun(std::string name, std::string out_dir, SessionFile* session)
    : name_(std::move(name)), out_dir_(std::move(out_dir)), session_(session) {}

Status VehicleRun::take(const vehicle::OutputList& outputs, FindingList& findings) {
  for (const vehicle::Output& output : outputs) {
    Status status;
    if (const auto* pose = std::get_if<vehicle::PoseEstimate>(&output)) {
      status = take_pose(*pose);
    } else if (const auto* added = std::get_if<vehicle::KeyframeAdded>(&output)) {
      status = take_keyframe(*added);
    } else if (const auto* corrected = std::get_if<vehicle::KeyframeCorrected>(&output)) {
      corrections_[corrected->id.seq] = *corrected;
    } else if (const auto* use = std::get_if<ranging::RangeUse>(&output)) {
      ++ranges_;
      if (use->used()) ++ranges_used_;
    } else if (const auto* gravity = std::get_if<vehicle::GravityEstimate>(&output)) {
      gravity_ = *gravity;
    } else if (const auto* made = std::get_if<vehicle::FactMade>(&output)) {
      facts_.push_back(made->fact);
      const auto* step = std::get_if<fleet::Increment>(&made->fact->body);
      knows_gravity_ |= step != nullptr && step->levelled;
    } else if (const auto* finding = std::get_if<Finding>(&output)) {
      findings.push_back(*finding);
      findings.back().vehicle = name_;
    }
    if (!status) return status;
  }
  return {};
}

Status VehicleRun::take_pose(const vehicle::PoseEstimate& pose) {
  PoseRecord record = pose_record(pose);
  // A run of facts has inertial data if it has a gravity estimate.
  record.held_by = hold_.see(pose, odometry_ ? t_imu_.has_value() : knows_gravity_);
  const bool good = record.quality != vehicle::PoseQuality::kDiverged;
  if (!poses_.empty() && good && poses_.back().quality != vehicle::PoseQuality::kDiverged) {
    const geometry::SE3 step = poses_.back().T_local_body.inverse() * record.T_local_body;
    path_m_ += step.p.norm();
    if (record.degenerate) degenerate_m_ += step.p.norm();
    // Only scans with rotation: the noise of hundreds of straight scans adds up to a rotation as
    // well.
    const double turn_rad = geometry::so3_log(step.R).norm();
    if (turn_rad > kTurnMin_rad) {
      gyro_ratio_.add_lidar(turn_rad);
      gyro_ratio_.add_gyro(gyro_turn_rad_.norm());
    }
  }
  gyro_turn_rad_.setZero();
  poses_.push_back(record);
  const geometry::Mat6 covariance =
      vehicle::odom_covariance(record.covariance, record.T_local_body, record.T_odom_body);
  if (odometry_) {
    if (good) keep(record.t, record.T_odom_body, covariance, odometry_track_);
    if (Status s = odometry_->add(record.t, record.T_odom_body, covariance); !s) return s;
  }
  return session_ != nullptr ? session_->add_pose(name_, record) : Status{};
}

Status VehicleRun::take_live(const LivePose& pose, const std::optional<FrameStep>& step) {
  keep(pose.t, pose.T_map_body, pose.covariance, live_track_);
  return live_->add(pose, step);
}

Status VehicleRun::take_keyframe(const vehicle::KeyframeAdded& added) {
  if (!added.keyframe) return {};
  Result<KeyframeRecord> record = write_keyframe(out_dir_, name_, added);
  if (!record) return tl::make_unexpected(record.error());
  // The pose of its scan comes in the same step or the previous one.
  for (auto pose = poses_.rbegin(); pose != poses_.rend() && pose->t >= record->t; ++pose) {
    if (pose->t == record->t) record->diverged = pose->quality == vehicle::PoseQuality::kDiverged;
  }
  keyframes_.push_back(std::move(*record));
  return {};
}

Status VehicleRun::see(const vehicle::Event& event) {
  if (const auto* imu = std::get_if<sensor::ImuSample>(&event)) {
    see_imu(*imu);
  } else if (const auto* scan = std::get_if<std::shared_ptr<const sensor::LidarScan>>(&event)) {
    if (session_ != nullptr) return session_->add_scan(name_, **scan);
  }
  return {};
}

void VehicleRun::see_imu(const sensor::ImuSample& sample) {
  // Rotation before the first pose has no counterpart in the LiDAR.
  if (t_imu_ && !poses_.empty()) {
    const double dt_s = sample.t.s() - t_imu_->s();
    if (dt_s > 0.0 && dt_s < 0.1) gyro_turn_rad_ += dt_s * sample.gyro_radps;
  }
  t_imu_ = sample.t;
  if (keep_imu_) imu_.push_back(sample);
}

geometry::SE3 VehicleRun::frame_so_far() const {
  if (poses_.empty()) return {};
  return level_frame(gravity_ ? gravity_->g_odom_mps2 : kDown_mps2, poses_.front().T_local_body);
}

void VehicleRun::join(const geometry::SE3& T_map_local, KeyframeCorrections keyframes) {
  T_map_local_joint_ = T_map_local;
  corrections_ = std::move(keyframes);
}

Status VehicleRun::finish() {
  correct_path(corrections_, poses_, keyframes_);
  const PathLength path = path_length(poses_);
  path_m_ = path.path_m;
  degenerate_m_ = path.degenerate_m;
  held_m_ = path.held_m;
  T_map_local_ = T_map_local_joint_.value_or(frame_so_far());
  const geometry::Vec3 g_odom = gravity_ ? gravity_->g_odom_mps2 : kDown_mps2;
  levelled_ |= knows_gravity_;
  if (knows_gravity_ && gravity_ && g_odom.norm() > 0.0) {
    const geometry::Vec3 down = g_odom.normalized();
    const geometry::Mat3 across = geometry::Mat3::Identity() - down * down.transpose();
    const double variance = (across * gravity_->covariance * across).trace();
    tilt_sigma_rad_ = std::sqrt(std::max(variance, 0.0)) / g_odom.norm();  // NaN stays NaN
  }
  // Files of published poses are closed whatever the session returns: they survive a full disk.
  Status shown = session_ != nullptr ? session_->add_path(name_, poses_, T_map_local_) : Status{};
  Status closed = odometry_ ? odometry_->close() : Status{};
  if (Status live = live_ ? live_->close() : Status{}; closed) closed = live;
  return closed ? shown : closed;
}

void VehicleRun::widen(Time begin, Time end, double sigma_m) {
  for (PoseRecord& pose : poses_) {
    if (pose.t < begin || pose.t > end) continue;
    pose.covariance.diagonal().tail<3>().array() += sigma_m * sigma_m;
  }
}

/// The first pose has no drift yet: its error in map is that of T_map_odom, up to the lever arm
/// from odom's origin to that pose. The trajectory is stated relative to the pose that defines the
/// map, so for the vehicle of that pose only the tilt remains.
std::optional<geometry::Mat6> VehicleRun::map_odom_covariance() const {
  const auto first = std::find_if(poses_.begin(), poses_.end(), [](const PoseRecord& pose) {
    return pose.quality != vehicle::PoseQuality::kDiverged;
  });
  if (first == poses_.end()) return std::nullopt;
  geometry::Mat6 J = geometry::Mat6::Identity();
  J.bottomRightCorner<3, 3>() = T_map_local_.R;
  const geometry::SE3 T_map_body = T_map_local_ * first->T_local_body;
  const geometry::Mat6 body =
      geometry::covariance_fixed_axes(J * first->covariance * J.transpose(), T_map_body.R);
  geometry::Mat6 lever = geometry::Mat6::Identity();
  lever.topRightCorner<3, 3>() = -geometry::skew(T_map_local_.p - T_map_body.p);
  return lever * body * lever.transpose();
}

void VehicleRun::summarise(VehicleSummary& summary) const {
  summary.name = name_;
  summary.scans = poses_.size();
  summary.path_m = path_m_;
  summary.degenerate_fraction = path_m_ > 0.0 ? degenerate_m_ / path_m_ : 0.0;
  summary.degenerate_held_fraction = degenerate_m_ > 0.0 ? held_m_ / degenerate_m_ : 0.0;
  summary.T_map_odom = T_map_local_;
  if (live_) summary.live = live_->tally();
  summary.levelled = levelled_;
  summary.tilt_sigma_rad = tilt_sigma_rad_;
  summary.keyframes = static_cast<std::size_t>(std::count_if(
      keyframes_.begin(), keyframes_.end(), [](const KeyframeRecord& k) { return !k.diverged; }));
  summary.T_map_odom_cov = map_odom_covariance();
  std::vector<double> sigmas;
  summary.diverged_s = 0.0;
  summary.sigma_median_m = summary.sigma_max_m = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    if (poses_[i].quality == vehicle::PoseQuality::kDiverged) {
      if (i > 0) summary.diverged_s += seconds_between(poses_[i - 1].t, poses_[i].t);
      continue;
    }
    sigmas.push_back(position_sigma_m(poses_[i]));
    if (!(sigmas.back() <= summary.sigma_max_m)) {
      summary.sigma_max_m = sigmas.back();
      summary.t_sigma_max = poses_[i].t;
    }
  }
  if (sigmas.empty()) return;
  const auto middle = sigmas.begin() + static_cast<std::ptrdiff_t>(sigmas.size() / 2);
  std::nth_element(sigmas.begin(), middle, sigmas.end());
  summary.sigma_median_m = *middle;
}

}  // namespace rali::drive
