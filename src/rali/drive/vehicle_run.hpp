#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/drive/input/imu_check.hpp"
#include "rali/drive/live/live_files.hpp"
#include "rali/drive/map_run.hpp"
#include "rali/drive/output/corrected_path.hpp"
#include "rali/drive/output/degenerate_hold.hpp"
#include "rali/drive/output/keyframe_files.hpp"
#include "rali/drive/output/pose_files.hpp"
#include "rali/drive/output/session_file.hpp"
#include "rali/monitor/track_check.hpp"
#include "rali/vehicle/event.hpp"

namespace rali::drive {

/// Collects one vehicle's outputs: streams them to disk as they come and keeps what the final files
/// need.
class VehicleRun {
 public:
  /// Creates odometry/<v>.tum and live/<v>.tum with their .cov.csv, and live/<v>.steps.csv. Errors:
  /// kMachine.
  /// @param session receives the run for viewers, may be null; must outlive the object
  [[nodiscard]] static Result<VehicleRun> start(const std::string& name, const std::string& out_dir,
                                                SessionFile* session);

  /// A run whose outputs are made of the facts that the vehicle sent. The poses published live are
  /// not known, so there is neither odometry/ nor live/.
  [[nodiscard]] static VehicleRun of_facts(const std::string& name, const std::string& out_dir,
                                           SessionFile* session);

  /// Marks the last pose as continuous with the one before, however long ago that was.
  void tie_last_pose() {
    if (poses_.size() > 1) poses_.back().tied = true;
  }

  /// Takes the outputs of one event; findings go to `findings`. Errors: kMachine.
  [[nodiscard]] Status take(const vehicle::OutputList& outputs, FindingList& findings);

  /// The vehicle's pose in the map as known at the time, and the step of T_map_odom. Errors:
  /// kMachine.
  [[nodiscard]] Status take_live(const LivePose& pose, const std::optional<FrameStep>& step);

  /// Receives each event before the vehicle does: inertial samples for the comparison of gyro and
  /// LiDAR, scans for the session. Errors: kMachine.
  [[nodiscard]] Status see(const vehicle::Event& event);

  /// The vehicle's result in the fleet's joint estimate: its frame, and its keyframes in odom. To
  /// be called before finish(); replaces the vehicle's own estimate.
  void join(const geometry::SE3& T_map_local, KeyframeCorrections keyframes);

  /// Closes the growing files, moves poses and keyframes by the corrections of ranges, and fixes
  /// the frame of the results. The odometry files keep what was published at the time.
  [[nodiscard]] Status finish();

  /// The facts that the vehicle reported, in their order.
  [[nodiscard]] const std::vector<std::shared_ptr<const fleet::Fact>>& facts() const {
    return facts_;
  }

  [[nodiscard]] const std::string& name() const { return name_; }

  [[nodiscard]] const std::vector<PoseRecord>& poses() const { return poses_; }

  [[nodiscard]] const std::vector<KeyframeRecord>& keyframes() const { return keyframes_; }

  /// Levels odom by the last gravity estimate; origin and heading are those of the first pose.
  /// Valid after finish().
  [[nodiscard]] const geometry::SE3& T_map_local() const { return T_map_local_; }

  [[nodiscard]] MapFrame map_frame() const {
    return {T_map_local_, levelled_, point_, T_body_point_};
  }

  /// The point of the vehicle that trajectory/ describes, instead of the body.
  void set_point(const std::string& name, const geometry::SE3& T_body_point) {
    point_ = name;
    T_body_point_ = T_body_point;
  }

  /// Keeps the inertial samples from now on, 56 bytes each.
  void keep_imu() { keep_imu_ = true; }

  [[nodiscard]] const std::vector<sensor::ImuSample>& imu_samples() const { return imu_; }

  /// Whether gravity was determined from the vehicle's own inertial data.
  [[nodiscard]] bool knows_gravity() const { return knows_gravity_; }

  /// The frame of the results is levelled by a vehicle that shares it.
  void share_level() { levelled_ = true; }

  /// NaN where gravity is not known.
  [[nodiscard]] double tilt_sigma_rad() const { return tilt_sigma_rad_; }

  [[nodiscard]] double path_m() const { return path_m_; }

  [[nodiscard]] double degenerate_m() const { return degenerate_m_; }

  /// Ranges that the vehicle received and how many of them it used.
  [[nodiscard]] std::size_t ranges() const { return ranges_; }

  [[nodiscard]] std::size_t ranges_used() const { return ranges_used_; }

  /// Twice a second, as published: poses in odom, and in the map as known at the time.
  [[nodiscard]] const std::vector<monitor::StatedPose>& odometry_track() const {
    return odometry_track_;
  }

  [[nodiscard]] const std::vector<monitor::StatedPose>& live_track() const { return live_track_; }

  /// Inflates the covariances of the final poses of a stretch. After finish().
  /// @param sigma_m of each axis, added to the stated covariance
  void widen(Time begin, Time end, double sigma_m);

  [[nodiscard]] double gyro_ratio() const { return gyro_ratio_.ratio(); }

  /// Numbers of the summary, except those of the input.
  void summarise(VehicleSummary& summary) const;

 private:
  VehicleRun(std::string name, std::string out_dir, SessionFile* session);

  void see_imu(const sensor::ImuSample& sample);
  [[nodiscard]] geometry::SE3 frame_so_far() const;

  [[nodiscard]] std::optional<geometry::Mat6> map_odom_covariance() const;
  [[nodiscard]] Status take_pose(const vehicle::PoseEstimate& pose);
  [[nodiscard]] Status take_keyframe(const vehicle::KeyframeAdded& added);

  std::string name_, out_dir_;
  std::optional<PoseFiles> odometry_;  ///< none: a run of facts
  std::optional<LiveFiles> live_;      ///< the same
  SessionFile* session_ = nullptr;
  std::vector<PoseRecord> poses_;
  std::vector<KeyframeRecord> keyframes_;
  std::optional<vehicle::GravityEstimate> gravity_;
  geometry::SE3 T_map_local_;
  bool knows_gravity_ = false, levelled_ = false;
  double tilt_sigma_rad_ = std::numeric_limits<double>::quiet_NaN();
  double path_m_ = 0.0, degenerate_m_ = 0.0, held_m_ = 0.0;
  std::size_t ranges_ = 0, ranges_used_ = 0;
  KeyframeCorrections corrections_;
  std::optional<geometry::SE3> T_map_local_joint_;
  std::vector<std::shared_ptr<const fleet::Fact>> facts_;
  DegenerateHold hold_;
  GyroRatio gyro_ratio_;
  geometry::Vec3 gyro_turn_rad_ = geometry::Vec3::Zero();  ///< since the last pose
  std::optional<Time> t_imu_;
  bool keep_imu_ = false;
  std::vector<sensor::ImuSample> imu_;
  std::string point_ = "body";
  geometry::SE3 T_body_point_;
  std::vector<monitor::StatedPose> odometry_track_, live_track_;
};

/// T_map_local that turns gravity to -z and puts the first pose to the origin, heading along +x.
[[nodiscard]] geometry::SE3 level_frame(const geometry::Vec3& g_odom_mps2,
                                        const geometry::SE3& T_odom_first);

}  // namespace rali::drive
