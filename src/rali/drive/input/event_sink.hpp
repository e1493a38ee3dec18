#pragma once

#include <memory>

#include "rali/sensor/imu_sample.hpp"
#include "rali/sensor/lidar_scan.hpp"
#include "rali/sensor/range_sample.hpp"

namespace rali::drive {

/// Interface of what puts events into order: recordings and live sensors do it differently.
class EventSink {
 public:
  virtual ~EventSink() = default;
  virtual void push(const sensor::ImuSample& sample) = 0;
  /// Also takes scans without points.
  virtual void push(std::shared_ptr<const sensor::LidarScan> scan) = 0;
  virtual void push(const sensor::RangeSample& sample) = 0;
};

}  // namespace rali::drive
