#pragma once

#include <array>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rali/cloud/voxel_sampler.hpp"
#include "rali/odometry/odometry.hpp"
#include "rali/odometry/robust/acceleration.hpp"
#include "rali/odometry/robust/bend.hpp"
#include "rali/odometry/robust/cover.hpp"
#include "rali/odometry/robust/drift.hpp"
#include "rali/odometry/robust/first_speed.hpp"
#include "rali/odometry/robust/inertial.hpp"
#include "rali/odometry/robust/initialiser.hpp"
#include "rali/odometry/robust/keyframer.hpp"
#include "rali/odometry/robust/laser_errors.hpp"
#include "rali/odometry/robust/lift_ride.hpp"
#include "rali/odometry/robust/map_tilt.hpp"
#include "rali/odometry/robust/scan_sampler.hpp"
#include "rali/odometry/robust/scan_view.hpp"
#include "rali/odometry/robust/standstill.hpp"
#include "rali/odometry/robust/stillness.hpp"
#include "rali/odometry/robust/turn_speed.hpp"
#include "rali/odometry/robust/update.hpp"
#include "rali/odometry/robust/vehicle_constraints.hpp"
#include "rali/odometry/settings.hpp"
#include "rali/odometry/travel_direction.hpp"

namespace rali::odometry::internal {

/// The filter behind make_robust_odometry(). The steps of a scan (predict, update, judge, insert)
/// are in robust_odometry.cpp, constrain in robust_motion.cpp; start, initialisation and restart in
/// robust_start.cpp; degenerate and refused directions in robust_thin.cpp.
class RobustOdometry final : public Odometry, private AugmentedFilter {
 public:
  RobustOdometry(const OdometrySettings& settings, const sensor::Calibration& calibration,
                 bool has_imu, const geometry::Vec3& forward_body)
      : settings_(settings.robust),
        noise_(settings.imu_noise),
        calibration_(calibration),
        has_imu_(has_imu),
        forward_body_(forward_body),
        sampler_(settings.robust.sampling),
        matcher_(settings.robust.match),
        map_(settings.robust.map),
        lasers_now_{{}, prior_laser_sigma_rad()},
        keyframer_(settings.robust.keyframe),
        drift_(settings.robust.drift, has_imu),
        track_drift_(drift_),
        standstill_(settings.robust.constraints, settings.robust.initialisation.rest),
        constraints_(settings.robust.constraints),
        motion_noise_(driving_noise(settings.imu_noise), settings.robust.motion_noise) {}

  void add_imu(const sensor::ImuSample& sample) override {
    if (has_imu_) imu_.add(sample);
  }

  ScanResult process(const sensor::LidarScan& scan, Executor& executor,
                     FindingList& findings) override;

  void finish(FindingList& findings) override;

  [[nodiscard]] geometry::Vec3 gravity_odom() const override { return state_.g_first_odom_mps2; }

  [[nodiscard]] geometry::Mat3 gravity_covariance() const override {
    const Eigen::Matrix<double, 3, 2> J =
        -geometry::skew(state_.g_first_odom_mps2) * gravity_basis(state_.g_first_odom_mps2);
    return J * state_.P.block<2, 2>(kFirstGravity, kFirstGravity) * J.transpose();
  }

  [[nodiscard]] std::uint64_t state_hash() const override;

  [[nodiscard]] AugmentedFilter* augmented_filter() override { return this; }

 private:
  // Measurements between scans: robust_augmented.cpp.
  [[nodiscard]] std::optional<Moment> advance_to(Time t) override;

  [[nodiscard]] const AugmentedStates& augmented() const override { return state_.augmented; }

  int add_states(const AugmentedStates::Vector& mean, const AugmentedStates::Matrix& covariance,
                 const AugmentedRowList& rows) override;
  void remove_states(int first, int n) override;
  void walk_side(int index, double variance) override;
  [[nodiscard]] double variance(const AugmentedMeasurement& measurement) const override;
  geometry::Vec3 apply(const AugmentedMeasurement& measurement, double R) override;
  [[nodiscard]] AugmentedStates::Matrix covariance(const AugmentedRowList& rows) const override;
  geometry::Vec3 replace(const AugmentedRowList& rows, const AugmentedStates::Vector& shift,
                         const AugmentedStates::Matrix& covariance) override;
  void widen(double factor) override;

  [[nodiscard]] std::optional<geometry::Vec3> degenerate_axis() const override {
    if (!degenerate_[0] || degenerate_[1]) return std::nullopt;
    return geometry::Vec3(axes_.col(0));
  }

  [[nodiscard]] int surfaces_between(const geometry::Vec3& p_odom_m,
                                     const geometry::Vec3& q_odom_m) const override;

  [[nodiscard]] geometry::Mat3 position_covariance() const override {
    return state_.P.block<3, 3>(kPos, kPos);
  }

  [[nodiscard]] Eigen::MatrixXd joint_rows(const AugmentedRowList& rows) const;
  void uncertainty_across(const geometry::Vec3& shift_m);
  void move_history(const FilterState& before);

  ScanResult start(const sensor::LidarScan& scan);
  void deskew_first(const sensor::LidarScan& second);
  void predict(Time t_end);
  void predict_inertial(Time t_end);
  // robust_lasers.cpp
  [[nodiscard]] const sensor::LidarScan& corrected(const sensor::LidarScan& scan);
  void measure_lasers(const sensor::LidarScan& scan);
  [[nodiscard]] double prior_laser_sigma_rad() const;
  [[nodiscard]] TiltRate tilt_rate() const;
  // Replay of a start in motion: robust_replay.cpp, robust_first_speed.cpp.
  void replay_start(const InitialGuess& guess, FindingList& findings);
  void insert_at_constant_speed(const sensor::LidarScan& scan,
                                const std::optional<geometry::Vec3>& gyro_radps);
  void poses_at_constant_speed(const sensor::LidarScan& scan,
                               const std::optional<geometry::Vec3>& gyro_radps);
  void set_range_noise(const sensor::LidarScan& scan);
  void turn_with_gyro(Time t_end);
  [[nodiscard]] std::optional<geometry::Vec3> gyro_rate(Time begin, Time end) const;
  [[nodiscard]] geometry::SE3 predicted_motion(Time t_end, const InertialIntegral& inertial) const;
  [[nodiscard]] ScanMotion scan_motion(const sensor::LidarScan& scan) const;
  UpdateResult predict_and_update(const sensor::LidarScan& scan, const InertialIntegral& inertial);
  UpdateResult update(const sensor::LidarScan& scan, int rounds);
  void bend_poses(const geometry::SE3& end);
  void remember_seen(const UpdateResult& done);
  void remember_blindness(const UpdateResult& done);
  [[nodiscard]] bool is_on_new_ground() const;
  [[nodiscard]] UpdateResult rejected() const;
  [[nodiscard]] bool is_covered(const FilterState& predicted, const UpdateResult& done) const;

  /// With fewer a scan does not outweigh the inertial data: in a map of few views planes may be
  /// false.
  [[nodiscard]] bool has_many_matches(const UpdateResult& done) const {
    return done.matches >= 3 * settings_.update.matches_min;
  }

  // The bend of a degenerate stretch: robust_bend.cpp.
  void follow_bend(const UpdateResult& done);
  void know_gyro_bias();
  void know_bias_at_standstill();
  void doubt_bias_in_bend();
  void measure_turn_speed(const InertialIntegral& inertial);
  void look_around(const FilterState& predicted, UpdateResult& done);
  // Checks of a scan without inertial data: robust_alone.cpp.
  bool settle_alone(const sensor::LidarScan& scan, const FilterState& predicted,
                    UpdateResult& done);
  void start_view(const sensor::LidarScan& scan);
  [[nodiscard]] double conflict_at(const ScanView& view) const;
  void search_widely(const FilterState& predicted, const ScanView& view, UpdateResult& done);
  void try_start(const FilterState& wide, const geometry::SE3& start, const ScanView& view,
                 UpdateResult& done);
  void stray(const FilterState& predicted, FindingList& findings);
  void stand_if_still();
  void remember_start(const sensor::LidarScan& scan, const UpdateResult& seen);
  void start_again_at_rest();

  struct StartMemory;

  /// A registration of a scan at one of several places.
  struct Placed {
    FilterState state;
    UpdateResult done;
    double agreement = 0.0;  ///< Matcher::agreement
  };

  /// The likeliest of the places where a scan fits after an interruption.
  struct FoundAgain {
    UpdateResult done;
    int places = 0;                                     ///< that look alike
    geometry::Mat3 spread_m2 = geometry::Mat3::Zero();  ///< of the others about it, in odom
  };

  /// At the start of a track, in odom.
  struct FirstSpeed {
    geometry::Vec3 v_odom_mps;
    double sigma_mps = 0.0;
    /// Nothing: as solved for along the track that this speed continues.
    std::optional<geometry::Vec3> g_odom_mps2 = {};
  };

  [[nodiscard]] StartMemory start_memory() const;
  void take(const StartMemory& memory);
  void level_start(const geometry::Vec3& g_odom_mps2, double span_s, FilterState& begin) const;
  FirstSpeedFit replay(std::span<const sensor::LidarScan> scans, const FirstSpeed& first,
                       FindingList& findings);
  void add_fit(const sensor::LidarScan& scan, const UpdateResult& done,
               const geometry::Vec3& ahead_odom, FirstSpeedFit& fit) const;
  [[nodiscard]] std::optional<FirstSpeed> find_first_speed(std::span<const sensor::LidarScan> scans,
                                                           const FirstSpeed* guess,
                                                           const StartMemory& before);
  void start_inertial(const InitialGuess& guess);
  bool start_early(const InitialGuess& guess, FindingList& findings);
  void end_start(bool at_rest, FindingList& findings);
  void try_initialise(FindingList& findings);
  void insert(const sensor::LidarScan& scan);
  void insert_points(const geometry::SE3& T_odom_body);
  std::optional<ScanResult> hold(const sensor::LidarScan& scan, FindingList& findings);
  // Standstill in a lift: robust_lift.cpp.
  bool follow_lift(const FilterState& held, double seen_up_m, FindingList& findings);
  bool enter_lift();
  [[nodiscard]] Finding lift_finding(const LiftRide::Height& height) const;
  void arrive(const sensor::LidarScan& scan, FindingList& findings);
  void refuse_lift(FindingList& findings);
  ScanResult riding(const sensor::LidarScan& scan, const UpdateResult& seen, double span_s);
  void start_zero_velocity(FindingList& findings);
  void end_zero_velocity(const FilterState& before);
  void constrain(const UpdateResult& done, FindingList& findings);
  void bound_speed(FindingList& findings);
  void widen_speed(const geometry::Vec3& axis_odom, FindingList& findings);
  [[nodiscard]] ProcessNoise process_noise() const;
  [[nodiscard]] ProcessNoise rest_noise() const;
  void measure_noise(const UpdateResult& seen, const InertialIntegral& inertial);
  [[nodiscard]] FilterState with_step(const FilterState& predicted, double size,
                                      const geometry::Mat3& where) const;
  void look_again(const FilterState& predicted, UpdateResult& done);
  void allow_jolt(const FilterState& predicted, UpdateResult& done);
  void refuse_thin_hold(const FilterState& predicted, const geometry::SE3& start,
                        UpdateResult& done);
  [[nodiscard]] std::array<bool, 3> closed() const;
  [[nodiscard]] std::optional<Level> level() const;
  geometry::Mat6 covariance(const UpdateResult& update);
  void release(const UpdateResult& update);
  void turn_with_map(const UpdateResult& update);
  void refuse_biases(const geometry::Vec3& gyro_before, const geometry::Vec3& accel_before,
                     FindingList& findings);
  void end_refusal(Time now, FindingList& findings);
  void report_refusal(FindingList& findings);
  void judge(const UpdateResult& update, FindingList& findings);
  void watch_acceleration(bool settled);
  void watch_travel(FindingList& findings);
  [[nodiscard]] std::string impossible_motion() const;
  void restart(const std::string& impossible, FindingList& findings);
  void start_anew();
  // Interruptions of all data: robust_gap.cpp.
  [[nodiscard]] bool is_interrupted(Time t_end) const;
  [[nodiscard]] FilterState anywhere_reached(Time t) const;
  void undistort_at(const sensor::LidarScan& scan, const geometry::SE3& T_odom_body,
                    const geometry::Vec3& v_odom_mps);
  Placed register_from(const geometry::SE3& start, const FilterState& wide);
  std::vector<Placed> place_again(const sensor::LidarScan& scan, const FilterState& wide);
  Placed at_best_speed(const sensor::LidarScan& scan, const FilterState& wide, const Placed& place);
  std::optional<FoundAgain> find_again(const sensor::LidarScan& scan, const FilterState& wide);
  UpdateResult resume(const sensor::LidarScan& scan, FindingList& findings);
  [[nodiscard]] bool speed_is_known_again(Time t) const;
  void widen_position(const geometry::Mat3& covariance_m2);
  void start_map();
  ScanResult result_of(const sensor::LidarScan& scan, const UpdateResult& update);

  RobustSettings settings_;
  ImuNoiseSettings noise_;
  sensor::Calibration calibration_;
  bool has_imu_;
  geometry::Vec3 forward_body_;  ///< along which the vehicle drives
  bool inertial_ = false;        ///< gravity is initialised, the filter uses inertial data
  bool started_ = false;

  FilterState state_;
  InertialBuffer imu_;
  std::vector<TimedPose> poses_;    ///< predicted since the last scan
  std::vector<TrackedPose> track_;  ///< until gravity is known
  ScanSampler sampler_;
  Matcher matcher_;
  PlaneMap map_;
  LaserErrors lasers_;
  LaserCalibration lasers_now_;                    ///< of lasers_, as subtracted from scans
  sensor::LidarScan corrected_;                    ///< the newest scan
  RecentPoints recent_;                            ///< all scans without inertial data
  std::unique_ptr<sensor::LidarScan> first_scan_;  ///< kept until the second scan shows its speed
  Keyframer keyframer_;
  Drift drift_;
  Drift track_drift_;  ///< when the track began
  StandstillDetector standstill_;
  VehicleConstraints constraints_;
  imu::MotionNoise motion_noise_;
  std::unique_ptr<ScanView> last_view_;  ///< of the last scan that was accepted, without IMU
  FilterState last_settled_;             ///< after that scan
  double usual_fit_ = 0.0;               ///< usual fraction of a scan's points on planes
  int driven_scans_ = 0;                 ///< with inertial data that show motion
  double noise_boost_ = 1.0;             ///< while inertial data contradict the LiDAR
  FilterState last_posterior_;           ///< after the last scan
  FilterState predicted_;                ///< for the newest scan
  geometry::SE3 T_predicted_;            ///< for the newest scan, before it was registered
  geometry::Mat3 P_predicted_m2_ = geometry::Mat3::Zero();  ///< of the predicted position
  AccelerationWatch acceleration_;
  CoverWatch cover_{calibration_.T_body_lidar.p};
  bool covered_ = false;            ///< the newest scan is of something that covers the LiDAR
  geometry::SE3 T_last_predicted_;  ///< predicted motion since the last scan
  geometry::SE3 T_propagated_;      ///< the same at constant velocity, up to now
  std::optional<Time> resumed_;     ///< found again then, the speed is not known yet
  bool new_map_ = false;            ///< started with the newest scan, the last map was lost
  std::optional<geometry::SE3> T_odom_first_;  ///< of the first result
  TravelDirection travel_;
  bool travel_reported_ = false;
  geometry::SE3 T_reported_;        ///< in the last result
  bool reported_inertial_ = false;  ///< in the last result
  /// Projector on the translations that the last scan observed well.
  geometry::Mat3 lidar_known_ = geometry::Mat3::Zero();
  bool at_standstill_ = false;  ///< the pose is kept fixed
  int moved_scans_ = 0;         ///< consecutive standstill scans in which the LiDAR saw motion
  /// So many are a motion: a passer-by in a degenerate corridor looks like one, too. A real start
  /// is also measured by the IMU.
  static constexpr int kScansToMove = 5;
  LiftRide lift_;             ///< since the last scan at rest
  FilterState before_lift_;   ///< then
  bool quiet_start_ = false;  ///< no motion detected since the first scan
  bool start_moved_ = false;  ///< the LiDAR shows motion along observable directions
  std::deque<FilterState> standstill_states_;   ///< of the last moments of standstill
  std::vector<BodyPoints> start_points_;        ///< of the first scans, until gravity is known
  std::vector<sensor::LidarScan> start_scans_;  ///< the same scans as measured
  double next_search_s_ = 0.0;  ///< length of the start at which the first speed is searched next
  BodyPoints points_;
  degeneracy::Axes axes_ = degeneracy::Axes::Identity();
  std::array<bool, 3> degenerate_{};   ///< translations along axes_ that are degenerate
  Bend bend_;                          ///< along the first of them
  TurnSpeed turn_speed_;               ///< along that one
  bool thin_ = false;                  ///< the support of that axis in this scan is refused
  std::array<int, 3> seeing_scans_{};  ///< consecutive scans in which each was observable
  TrackState track_state_ = TrackState::kWaiting;
  static constexpr int kYoungScans = 5;
  int scans_in_map_ = 0;
  Time t_last_good_;
  std::optional<Time> t_unmatched_;  ///< the first of the newest scans that match too few planes
  Time t_speed_bounded_;
  Time t_degenerate_;  ///< start of the degenerate stretch along the first axis, except glimpses
  std::optional<Time> t_seen_;  ///< when that axis was last observable again
  static constexpr double kGlimpse_s = 5.0;
  double fastest_seen_mps_ = 0.0;  ///< while the LiDAR is not degenerate
  geometry::SE3 last_good_;

  /// A period in which bias updates were refused.
  struct Refusal {
    Time begin, last;
    bool gyro = false;  ///< the gyro's bias was refused first
  };

  std::optional<Refusal> refusal_;
};

}  // namespace rali::odometry::internal
