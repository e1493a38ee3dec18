#pragma once

#include <chrono>

#include "rali/drive/vehicle_run.hpp"

namespace rali::drive {

/// Reports a vehicle's progress to the sink, at most ten times per second of wall clock: printing
/// must not cost time, and nothing here enters a result.
class LoopProgress {
 public:
  LoopProgress(ProgressSink& sink, const VehicleRun& run) : sink_(sink), run_(run) {}

  /// @param always report even if the last report is less than a tenth of a second old
  void report(double fraction, bool always);

 private:
  ProgressSink& sink_;
  const VehicleRun& run_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point last_;
};

}  // namespace rali::drive
