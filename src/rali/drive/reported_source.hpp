#pragma once

#include <memory>

#include "rali/drive/event_source.hpp"
#include "rali/drive/input/input_report.hpp"

namespace rali::drive {

/// An event source that reports its input decisions and what was missing. Scans are in the LiDAR
/// frame, inertial samples in SI units in the IMU frame: a vehicle fed by it uses
/// report().T_body_lidar and report().T_body_imu.
class ReportedSource : public EventSource {
 public:
  /// Decisions are final from the start; counts and findings grow until the end.
  [[nodiscard]] virtual const InputReport& report() const = 0;
};

}  // namespace rali::drive
