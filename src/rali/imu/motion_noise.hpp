#pragma once

#include <array>
#include <deque>
#include <optional>

#include "rali/base/settings.hpp"
#include "rali/base/time.hpp"
#include "rali/geometry/types.hpp"

namespace rali::imu {

/// White noise of an inertial sensor as a filter needs it: all that makes its integral wrong over a
/// second, the sensor's own noise being the smallest part on a vehicle that drives.
struct NoiseDensity {
  double gyro_radps_rthz = 3e-3;
  double accel_mps2_rthz = 0.03;
};

/// Noise as measured while driving; empty where too little was driven, or the LiDAR is degenerate.
struct MeasuredNoise {
  std::optional<double> gyro_radps_rthz, accel_mps2_rthz;
};

/// What is known of the noise before anything is measured, and how fast measurements take over.
struct MotionNoiseSettings {
  double gyro_typical_radps_rthz = 3e-3;
  double accel_typical_mps2_rthz = 0.03;
  double typical_factor = 3.0;
  double claimed_factor = 10.0;
  double short_s = 0.2, long_s = 0.6;
  double memory_s = 12.0;

  template <class V>
  void visit(V& v) {
    v("gyro_typical_radps_rthz", gyro_typical_radps_rthz, 1e-6, 1.0,
      "gyro noise of vehicles that drive, before it is measured");
    v("accel_typical_mps2_rthz", accel_typical_mps2_rthz, 1e-5, 10.0,
      "accelerometer noise of vehicles that drive, before it is measured");
    v("typical_factor", typical_factor, 1.1, 100.0, "sigma of that, a factor");
    v("claimed_factor", claimed_factor, 1.1, 1000.0, "sigma of what the user gives, a factor");
    v("short_s", short_s, 0.02, 10.0, "lag over which the LiDAR's noise shows");
    v("long_s", long_s, 0.05, 30.0, "lag over which the inertial sensor's noise shows");
    v("memory_s", memory_s, 1.0, 1000.0, "so much driving is remembered");
  }
};

/// What the noise is taken for before it is measured: typical for vehicles, moved a little by what
/// the user claims. Data sheets state the sensor at rest on a table, often in other units; a figure
/// copied from one must never make the result worse.
/// @param claimed  of the user, with the factor that driving adds
[[nodiscard]] NoiseDensity prior_noise(const NoiseDensity& claimed,
                                       const MotionNoiseSettings& settings);

/// What LiDAR and inertial sensor each say of the motion since the last scan.
struct MotionStep {
  Time t;
  geometry::Mat3 R_odom_body = geometry::Mat3::Identity();  ///< by the LiDAR
  geometry::Vec3 p_odom_m = geometry::Vec3::Zero();         ///< by the LiDAR
  /// Projector on the directions in which the LiDAR alone knows the position.
  geometry::Mat3 known = geometry::Mat3::Zero();
  bool rotation_known = false;
  /// Integral of force and gravity since the last step, and the displacement by it alone, in odom.
  geometry::Vec3 dv_mps = geometry::Vec3::Zero();
  geometry::Vec3 dp_m = geometry::Vec3::Zero();
  geometry::Mat3 dR = geometry::Mat3::Identity();  ///< by the gyro, from the last body to this one
};

/// Measures the noise of an inertial sensor in motion by comparing it with the LiDAR over two lags,
/// as an Allan variance does: over the short lag the noise of the LiDAR shows, over the long one
/// that of the integrated inertial data. Second differences of positions are free of the velocity,
/// their slow mean of biases and tilt. Whatever the cause (vibration, jolts shorter than a sample,
/// stamps, scale), it is measured where it does harm.
class MotionNoise {
 public:
  MotionNoise(const NoiseDensity& claimed, const MotionNoiseSettings& settings);

  /// Once for each scan in which the vehicle moves and the step has inertial data.
  void add(const MotionStep& step);

  /// The chain of steps is broken: a gap, a new map, a standstill.
  void interrupt() { steps_.clear(); }

  /// The densities to use now.
  [[nodiscard]] const NoiseDensity& density() const { return density_; }

  /// Of it what rests on enough measured values.
  [[nodiscard]] MeasuredNoise measured() const;

  /// Mean of what was measured while driving, with the number of independent values behind it.
  struct Measured {
    double value = 0.0;
    double count = 0.0;
  };

  [[nodiscard]] const Measured& gyro() const { return gyro_; }

  [[nodiscard]] const Measured& accel() const { return accel_; }

 private:
  /// Mean square of what two sensors differ by over one lag, outliers bounded, slow mean removed.
  struct Spread {
    geometry::Vec3 mean = geometry::Vec3::Zero();
    double square = 0.0;
    double weight = 0.0;
    double lag_s = 0.0;  ///< mean

    void add(const geometry::Vec3& difference, const geometry::Mat3& known, double dt_s,
             double memory_s);
  };

  [[nodiscard]] std::optional<std::size_t> step_before(std::size_t from, double lag_s) const;
  void compare(double lag_s, Spread& accel, Spread& gyro);
  [[nodiscard]] double combined(double prior, const Measured& measured, double floor) const;

  MotionNoiseSettings settings_;
  NoiseDensity claimed_, prior_, density_;
  std::deque<MotionStep> steps_;
  std::array<Spread, 2> accel_spread_, gyro_spread_;  ///< short, long lag
  Measured gyro_, accel_;
};

}  // namespace rali::imu
