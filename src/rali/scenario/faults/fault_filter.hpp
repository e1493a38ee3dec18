#pragma once

#include <optional>
#include <vector>

#include "rali/base/rng.hpp"
#include "rali/scenario/faults/fault.hpp"
#include "rali/sim/fleet/fleet_simulation.hpp"

namespace rali::scenario {

/// Applies faults to the sensor messages of a fleet. Unaffected messages pass unchanged, so that a
/// faulty recording differs from the intact one only in the fault.
class FaultFilter {
 public:
  /// @param start  of the recording: fault times are relative to it
  FaultFilter(std::vector<Fault> faults, Time start, std::uint64_t seed);

  /// The message as recorded, empty if lost. Call in order of arrival.
  [[nodiscard]] std::optional<sim::FleetMessage> apply(sim::FleetMessage message);

  /// Time at which the file of a vehicle is truncated, if it is.
  [[nodiscard]] std::optional<Time> cut_at(int vehicle) const;

  [[nodiscard]] const std::vector<Fault>& faults() const { return faults_; }

 private:
  using ScanPtr = std::shared_ptr<const sensor::LidarScan>;

  [[nodiscard]] bool active(const Fault& fault, int vehicle, Time t) const;
  /// False if the message is lost.
  bool spoil(std::size_t i, int vehicle, sensor::ImuSample& imu, Time t);
  bool spoil(std::size_t i, int vehicle, ScanPtr& scan, Time t);
  bool spoil(std::size_t i, int vehicle, sensor::RangeSample& range, Time t);
  bool spoil(std::size_t i, int vehicle, sensor::RadioSample& radio, Time t);

  std::vector<Fault> faults_;
  Time start_;
  std::vector<Rng> chance_;  ///< one stream per fault
};

}  // namespace rali::scenario
