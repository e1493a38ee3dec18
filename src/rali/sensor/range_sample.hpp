#pragma once

#include "rali/base/ids.hpp"
#include "rali/base/time.hpp"

namespace rali::sensor {

/// One radio range between two antennas.
struct RangeSample {
  Time t;
  VehicleId from, to;
  std::uint8_t from_antenna = 0, to_antenna = 0;  ///< index in the vehicle's list of antennas
  double range_m = 0.0;
  double sigma_m = 0.0;         ///< 0: take the setting's
  double rssi_dbm = 0.0;        ///< 0: unknown
  double first_path_dbm = 0.0;  ///< 0: unknown
  VehicleId clock;              ///< the vehicle whose clock has stamped it, in recordings
};

/// Strength of the radio link between two vehicles.
struct RadioSample {
  Time t;
  VehicleId from, to;
  double rssi_dbm = 0.0;
};

}  // namespace rali::sensor
