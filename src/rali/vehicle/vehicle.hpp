#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "rali/base/executor.hpp"
#include "rali/imu/motion_noise.hpp"
#include "rali/vehicle/event.hpp"
#include "rali/vehicle/settings.hpp"

namespace rali::vehicle {

/// Delay of a range's measurement after its stamp, as estimated by the filter from the motion.
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

  /// Noise of the inertial data while driving, over the whole drive; empty in preset `paper`.
  [[nodiscard]] imu::MeasuredNoise measured_noise() const;

  /// Hash of the whole state: locates the first event at which two runs diverge.
  [[nodiscard]] std::uint64_t state_hash() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rali::vehicle
