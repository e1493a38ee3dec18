#pragma once

#include <deque>
#include <vector>

#include "rali/base/finding.hpp"
#include "rali/imu/preintegration.hpp"
#include "rali/imu/rest.hpp"
#include "rali/odometry/deskew.hpp"
#include "rali/odometry/imu_noise.hpp"
#include "rali/odometry/odometry.hpp"
#include "rali/odometry/paper/local_graph.hpp"

namespace rali::odometry::paper {

/// Gravity of odom: its z axis is up by construction [m/s^2].
inline const geometry::Vec3 kGravityOdom{0.0, 0.0, -9.81};

/// Initial guesses of scan poses from inertial data, and the velocity and biases they need. The
/// paper states only that preintegration gives the guess: docs/explain/math/paper_odometry.md.
class InertialGuess {
 public:
  enum class Start { kWait, kAtRest, kInMotion };

  /// @param velocity_gain fraction of a scan's velocity innovation applied to the velocity
  /// @param bias_gain fraction of a scan's rate and acceleration innovation applied to the biases
  InertialGuess(const ImuNoiseSettings& noise, const geometry::SE3& T_body_imu,
                double velocity_gain, double bias_gain);

  /// Samples in time order; samples that are not finite or not later than the last are ignored.
  void add(const sensor::ImuSample& sample);

  /// Tries to initialise attitude and biases at time t: from a second of standstill, or at the
  /// first motion from the mean acceleration so far. Sets the state on success, with yaw and
  /// position 0.
  Start try_start(Time t, FindingList& findings);

  /// Moves the state to t_end by preintegration, or at constant velocity if samples cover less than
  /// half of the interval. `poses` receives the body's path, first and last included.
  void predict(Time t_end, std::vector<TimedPose>& poses);

  /// Takes the registered pose at the time last predicted to. Corrects the velocity towards that of
  /// the last two registered poses and the inertial deltas between them.
  void correct(const geometry::SE3& T_odom_body);

  /// Fuses a registration at the time last predicted to with the inertial data by the local graph.
  /// @param information,pull of the body's pose, as RegistrationResult gives them
  void fuse(const geometry::Mat6& information, const geometry::Vec6& pull);

  /// Transforms the whole state, past included, within odom: T_odom_body becomes T_new_old
  /// T_odom_body. The velocity is rotated too; covariance and biases are unchanged.
  void move(const geometry::SE3& T_new_old);

  /// Deltas since start_keyframe(); null where samples were missing.
  [[nodiscard]] const imu::Preintegration* since_keyframe() const {
    return keyframe_covered_ && pre_keyframe_.size() > 0 ? &pre_keyframe_ : nullptr;
  }

  /// The state is that of a keyframe: deltas restart with the current biases.
  void start_keyframe();

  [[nodiscard]] KeyframeMotion motion() const { return {state_.v_odom_mps, bias_}; }

  /// Biases beyond the limits of an intact sensor are clipped.
  void set_motion(const KeyframeMotion& motion);

  /// As fuse(), for the covariance only: the pose itself is set by correct().
  void fuse_covariance(const geometry::Mat6& information);

  /// Standstill since the time last predicted to: zero velocity, and the gyro measures its bias.
  void start_standstill();
  /// Standstill continues, at this pose.
  void stay(const geometry::SE3& T_odom_body);

  /// A measurement of the body's position along a direction; move() has already been applied.
  void know_along(const KnownAlong& known);

  /// Adds a random walk of this density to the accelerometer bias over the last prediction.
  void let_accel_bias_wander(double walk_mps3_rthz) {
    graph_.let_accel_bias_wander(walk_mps3_rthz * walk_mps3_rthz * predicted_s_);
  }

  /// Covariance of the body's pose by the local graph, boxplus order.
  [[nodiscard]] geometry::Mat6 covariance() const;

  /// State of the IMU, at the time last predicted to.
  [[nodiscard]] const imu::InertialState& state() const { return state_; }

  /// Covariance of state() and the biases, in the order of the local graph.
  [[nodiscard]] const LocalGraph::Mat15& inertial_covariance() const { return graph_.covariance(); }

  /// The last accepted sample, in m/s^2 and rad/s; null if there is none.
  [[nodiscard]] const sensor::ImuSample* newest_sample() const {
    return samples_.empty() ? nullptr : &samples_.back();
  }

  /// Sets the pose at time t with zero velocity.
  void reset(Time t, const geometry::SE3& T_odom_body);

  [[nodiscard]] geometry::SE3 T_odom_body() const;

  [[nodiscard]] geometry::Vec3 v_odom_body_mps() const;

  /// Rotation since the last registered pose, by the gyro.
  [[nodiscard]] const geometry::Mat3& rotation_since_last() const { return delta_rotation_; }

  [[nodiscard]] const imu::InertialBias& bias() const { return bias_; }

  /// True if the last prediction had inertial samples.
  [[nodiscard]] bool inertial() const { return inertial_; }

 private:
  struct PastPose {
    Time t;
    geometry::SE3 T_odom_imu;
  };

  [[nodiscard]] std::vector<sensor::ImuSample> block_means(Time begin, Time end) const;
  [[nodiscard]] std::vector<sensor::ImuSample> between(Time begin, Time end) const;
  [[nodiscard]] sensor::ImuSample at(Time t) const;
  void scale_units(FindingList& findings);
  void set_attitude(const std::vector<sensor::ImuSample>& samples, bool at_rest);
  double integrate_to(Time t_end, std::vector<TimedPose>& poses);
  void coast_to(Time t_end);
  void drop_used();
  void cut_biases();
  void learn_gyro_bias();
  void remember_registered();
  [[nodiscard]] geometry::Mat6 d_body_d_imu() const;
  void track_biases(const geometry::Vec3& velocity_innovation_mps, const geometry::Mat3& R_odom_imu,
                    double dt_s);

  geometry::SE3 T_body_imu_;
  double velocity_gain_;
  double bias_gain_;
  std::deque<sensor::ImuSample> samples_;
  double accel_scale_ = 1.0;  ///< 9.81 if the sensor reports g
  bool units_known_ = false;

  Time t_;
  imu::InertialState state_;                                ///< of the IMU, at t_
  geometry::Vec3 rate_imu_radps_ = geometry::Vec3::Zero();  ///< at t_, for constant velocity
  imu::InertialBias bias_;
  imu::Preintegration pre_;
  imu::Preintegration pre_keyframe_;
  bool keyframe_covered_ = false;
  LocalGraph graph_;
  imu::InertialState last_registered_;
  Time t_last_registered_;
  geometry::Mat3 delta_rotation_ = geometry::Mat3::Identity();
  std::deque<PastPose> past_;  ///< registered poses of the last second
  bool inertial_ = false;
  double predicted_s_ = 0.0;
};

}  // namespace rali::odometry::paper
