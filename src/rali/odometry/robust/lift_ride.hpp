#pragma once

#include <deque>
#include <span>

#include "rali/base/time.hpp"
#include "rali/odometry/robust/state.hpp"
#include "rali/sensor/imu_sample.hpp"

namespace rali::odometry {

/// A vehicle that stands in a lift or a mine cage. Its LiDAR sees the cabin stand still and cannot
/// know that both move; the accelerometer feels it. The force along gravity that standstill does
/// not explain is integrated from one standstill to the next. At both ends the speed is zero, which
/// measures the error of the force: the height is known to centimetres.
class LiftRide {
 public:
  /// Standstill now, not before.
  void stand(Time t);

  /// No force has acted lately. If for a second, the vehicle has stood since its start.
  bool stands();

  /// After a break the ride begins anew, at the time of `held`.
  /// @param samples the next ones, in the body
  /// @param held attitude, bias and gravity at standstill
  /// @param white_mps2_rthz noise of the accelerometer
  void add(std::span<const sensor::ImuSample> samples, const FilterState& held,
           double white_mps2_rthz);

  /// It has stood for a second: only from there on is the speed known.
  [[nodiscard]] bool has_stood() const { return has_stood_; }

  /// The vehicle has moved up or down by more than a LiDAR could overlook.
  [[nodiscard]] bool rides() const { return rides_; }

  /// The ride has ended: no force for a while, and a speed that may be zero.
  [[nodiscard]] bool arrived() const;

  /// No lift accelerates for so long: the sensor's error has changed.
  [[nodiscard]] bool is_sensor_error() const;

  [[nodiscard]] double duration_s() const { return (now_.t - begin_).s(); }

  [[nodiscard]] Time begin() const { return begin_; }

  [[nodiscard]] double speed_mps() const { return now_.speed_mps; }

  /// Height and its standard deviation since the last standstill. Once arrived, the speed is known
  /// to be zero now.
  struct Height {
    double up_m = 0.0, sigma_m = 0.0;
  };

  [[nodiscard]] Height height() const;

 private:
  struct Moment {
    Time t;
    double speed_mps = 0.0;
  };

  [[nodiscard]] double speed_sigma_mps() const;
  /// The speed has not changed lately.
  [[nodiscard]] bool is_steady() const;
  /// Lately is a second.
  [[nodiscard]] bool is_long() const;

  Time begin_;
  Moment now_;
  double height_m_ = 0.0;
  double force_mps2_ = 0.0;        ///< at now_
  double force_sigma_mps2_ = 0.0;  ///< of a constant error
  double white_mps2_rthz_ = 0.0;
  double fastest_mps_ = 0.0;
  bool has_stood_ = false;
  bool rides_ = false;
  std::deque<Moment> recent_;
};

/// The samples as they would be if standstill explained their force along gravity.
void remove_lift(const FilterState& held, std::span<sensor::ImuSample> samples);

}  // namespace rali::odometry
