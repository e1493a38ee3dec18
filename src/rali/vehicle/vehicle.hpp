#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "rali/base/executor.hpp"
#include "rali/imu/motion_noise.hpp"
#include "rali/vehicle/event.hpp"
#include "rali/vehicle/settings.hpp"

namespace rali::vehicle {

/// How much later than its stamp a range was measured, as the filter has it from the motion.
struct RangeStampOffset {
  double value_s = 0.0;
  double sigma_s = 0.0;
};

/// One vehicle's software as a pure function of its events: no clock, thread, file or socket.
/// Same settings and events: same outputs, byte for byte.
class Vehicle {
 public:
  Vehicle(VehicleId self, const VehicleSettings& settings);
  ~Vehicle();
  Vehicle(Vehicle&&) noexcept;
  Vehicle& operator=(Vehicle&&) noexcept;

  /// Takes one event and appends what follows from it to `out`. Never blocks or throws for bad
  /// data: an event that cannot be used is refused with a Finding.
  void step(const Event& event, Executor& executor, OutputList& out);

  /// Empty before the filter has used a range, and in preset `paper`.
  [[nodiscard]] std::optional<RangeStampOffset> range_stamp_offset() const;

  /// Of the inertial data while driving, over the whole drive; empty in preset `paper`.
  [[nodiscard]] imu::MeasuredNoise measured_noise() const;

  /// Hash of the whole state: finds the first event at which two runs part.
  [[nodiscard]] std::uint64_t state_hash() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rali::vehicle
