#pragma once

#include <array>
#include <deque>
#include <optional>

#include "rali/base/settings.hpp"
#include "rali/base/time.hpp"
#include "rali/geometry/types.hpp"

namespace rali::imu {

/// White noise of an inertial sensor for use in a filter: all errors that accumulate in its
/// integral over a second. On a driving vehicle the sensor's own noise is the smallest part.
struct NoiseDensity {
  double gyro_radps_rthz = 3e-3;
  double accel_mps2_rthz = 0.03;
};

/// Noise measured while driving; empty with too little driving, or where the LiDAR is degenerate.
struct MeasuredNoise {
  std::optional<double> gyro_radps_rthz, accel_mps2_rthz;
};

/// Prior of the noise, and how fast measurements replace it.
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

/// The noise density assumed before it is measured: typical for vehicles, slightly adjusted by the
/// figure the user claims. Data sheets specify the sensor at rest on a table, often in other units;
/// a copied figure must never make the result worse.
/// @param claimed by the user, including the factor for driving
[[nodiscard]] NoiseDensity prior_noise(const NoiseDensity& claimed,
                                       const MotionNoiseSettings& settings);

/// Motion since the last scan, as measured by the LiDAR and by the inertial sensor.
struct MotionStep {
  Time t;
  geometry::Mat3 R_odom_body = geometry::Mat3::Identity();  ///< from the LiDAR
  geometry::Vec3 p_odom_m = geometry::Vec3::Zero();         ///< from the LiDAR
  /// Projector on the directions in which the position is observable by the LiDAR alone.
  geometry::Mat3 known = geometry::Mat3::Zero();
  /// The same for rotations, about axes of the body: in a round pipe, roll is not.
  geometry::Mat3 rotation_known = geometry::Mat3::Zero();
  /// Integral of force and gravity since the last step, and the displacement from it alone, in
  /// odom.
  geometry::Vec3 dv_mps = geometry::Vec3::Zero();
  geometry::Vec3 dp_m = geometry::Vec3::Zero();
  geometry::Mat3 dR =
      geometry::Mat3::Identity();  ///< from the gyro, from the last body to this one
};

/// Measures the noise of an inertial sensor in motion by comparing it with the LiDAR over two lags,
/// like an Allan variance. The short lag shows the noise of the LiDAR, the long one that of the
/// integrated inertial data. Second differences of positions cancel the velocity; subtracting their
/// slow mean cancels biases and tilt. All causes are included (vibration, jolts shorter than a
/// sample, stamps, scale), because the comparison uses the integral that the filter uses.
class MotionNoise {
 public:
  MotionNoise(const NoiseDensity& claimed, const MotionNoiseSettings& settings);

  /// Call once per scan in which the vehicle moves and the step has inertial data.
  void add(const MotionStep& step);

  /// Breaks the chain of steps: after a gap, a new map or a standstill.
  void interrupt() { steps_.clear(); }

  /// The densities to use now.
  [[nodiscard]] const NoiseDensity& density() const { return density_; }

  /// The part of density() that is based on enough measured values.
  [[nodiscard]] MeasuredNoise measured() const;

  /// Mean of the noise measured while driving, with the number of independent values in it.
  struct Measured {
    double value = 0.0;
    double count = 0.0;
  };

  [[nodiscard]] const Measured& gyro() const { return gyro_; }

  [[nodiscard]] const Measured& accel() const { return accel_; }

 private:
  /// Mean square difference of the two sensors over one lag, outliers bounded, slow mean removed.
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
