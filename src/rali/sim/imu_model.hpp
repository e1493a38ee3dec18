#pragma once

#include <vector>

#include "rali/base/rng.hpp"
#include "rali/base/settings.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/sensor/imu_sample.hpp"
#include "rali/sim/trajectory.hpp"

namespace rali::sim {

/// Errors of the inertial sensor. Densities as in data sheets; per-sample sd = density *
/// sqrt(rate).
struct ImuOptions {
  double rate_hz = 200.0;
  double gyro_radps_rthz = 1.5e-3;
  double accel_mps2_rthz = 1e-2;
  double gyro_walk_radps2_rthz = 1e-5;
  double accel_walk_mps3_rthz = 1e-4;
  double gyro_bias_radps = 0.003;      ///< sd per axis of the turn-on bias
  double accel_bias_mps2 = 0.03;       ///< sd per axis of the turn-on bias
  double vibration_gyro_radps = 0.01;  ///< sd at 1 m/s, around 40 Hz
  double vibration_accel_mps2 = 0.3;   ///< sd at 1 m/s, around 40 Hz
  /// Structural resonances of the vehicle: a few narrow bands excited while it drives, independent
  /// of its speed.
  double resonance_gyro_radps = 0.0;  ///< rms of each axis
  double resonance_accel_mps2 = 0.0;  ///< rms of each axis
  double resonance_low_hz = 11.0;     ///< the frequencies are drawn from this band
  double resonance_high_hz = 38.0;
  double scale_error = 0.0;         ///< of gyroscope and accelerometer, relative
  double misalignment_deg = 0.0;    ///< of gyroscope and accelerometer, each in a random direction
  double gyro_limit_radps = 35.0;   ///< saturation
  double accel_limit_mps2 = 160.0;  ///< saturation
  double time_offset_s = 0.0;       ///< added to the stamps
  bool accel_in_g = false;          ///< simulates a driver with the wrong unit
  bool gyro_in_degps = false;       ///< simulates a driver with the wrong unit

  /// The same sensor without any error.
  [[nodiscard]] static ImuOptions ideal();

  template <class V>
  void visit(V& v) {
    v("rate_hz", rate_hz, 10.0, 2000.0, "samples per second");
    v("gyro_radps_rthz", gyro_radps_rthz, 0.0, 1.0, "gyro white noise");
    v("accel_mps2_rthz", accel_mps2_rthz, 0.0, 10.0, "accelerometer white noise");
    v("gyro_walk_radps2_rthz", gyro_walk_radps2_rthz, 0.0, 1.0, "gyro bias walk");
    v("accel_walk_mps3_rthz", accel_walk_mps3_rthz, 0.0, 10.0, "accelerometer bias walk");
    v("gyro_bias_radps", gyro_bias_radps, 0.0, 1.0, "sd of the gyro bias at the start");
    v("accel_bias_mps2", accel_bias_mps2, 0.0, 10.0, "sd of the accelerometer bias at the start");
    v("vibration_gyro_radps", vibration_gyro_radps, 0.0, 1.0, "gyro vibration at 1 m/s");
    v("vibration_accel_mps2", vibration_accel_mps2, 0.0, 50.0, "accelerometer vibration at 1 m/s");
    v("resonance_gyro_radps", resonance_gyro_radps, 0.0, 5.0, "gyro resonances while driving, rms");
    v("resonance_accel_mps2", resonance_accel_mps2, 0.0, 50.0,
      "accelerometer resonances while driving, rms");
    v("resonance_low_hz", resonance_low_hz, 0.1, 1000.0, "lower end of their band");
    v("resonance_high_hz", resonance_high_hz, 0.1, 1000.0, "upper end of their band");
    v("scale_error", scale_error, -0.5, 0.5, "relative scale error of both triads");
    v("misalignment_deg", misalignment_deg, 0.0, 10.0, "of both triads, in random directions");
    v("gyro_limit_radps", gyro_limit_radps, 0.1, 1000.0, "gyro saturates here");
    v("accel_limit_mps2", accel_limit_mps2, 1.0, 10000.0, "accelerometer saturates here");
    v("time_offset_s", time_offset_s, -1.0, 1.0, "added to the stamps");
    v("accel_in_g", accel_in_g, "accelerometer output in g");
    v("gyro_in_degps", gyro_in_degps, "gyro output in deg/s");
  }
};

inline constexpr double kGravity_mps2 = 9.81;

/// Ideal measurement of an inertial sensor at T_body_imu: rates and specific force.
[[nodiscard]] sensor::ImuSample ideal_imu(Time t, const MotionState& state,
                                          const geometry::SE3& T_body_imu);

/// Adds errors to ideal samples; samples must be passed in time order.
class ImuModel {
 public:
  ImuModel(const ImuOptions& options, std::uint64_t seed);

  /// @param speed_mps  of the vehicle: vibration grows with it
  [[nodiscard]] sensor::ImuSample measure(const sensor::ImuSample& ideal, double speed_mps);

  [[nodiscard]] const geometry::Vec3& gyro_bias_radps() const { return gyro_bias_; }

  [[nodiscard]] const geometry::Vec3& accel_bias_mps2() const { return accel_bias_; }

 private:
  /// Noise with standard deviation 1 around one frequency, a second-order autoregression.
  struct Vibration {
    double centre_hz = 40.0;
    double radius = 0.9;  ///< of the pole: width of the resonance
    geometry::Vec3 last = geometry::Vec3::Zero();
    geometry::Vec3 before = geometry::Vec3::Zero();
    geometry::Vec3 next(Rng& rng, double rate_hz);
  };

  /// Sum of the structural resonances, standard deviation 1.
  struct Resonances {
    std::vector<Vibration> modes;
    geometry::Vec3 next(Rng& rng, double rate_hz);
  };

  [[nodiscard]] Resonances draw_resonances(Rng& rng) const;

  ImuOptions options_;
  Rng white_, walk_, shake_, ring_;
  geometry::Vec3 gyro_bias_, accel_bias_;
  geometry::Mat3 R_gyro_, R_accel_;  ///< misaligned triads
  Vibration gyro_vibration_, accel_vibration_;
  Resonances gyro_resonances_, accel_resonances_;
};

}  // namespace rali::sim
