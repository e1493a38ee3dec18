#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "rali/types.hpp"

namespace rali {

/// One inertial measurement in the frame of the IMU.
struct ImuSample {
  std::int64_t stamp_ns = 0;
  Vec3 gyro_radps = Vec3::Zero();
  Vec3 accel_mps2 = Vec3::Zero();  ///< specific force: at standstill with z up, +9.81 in z
};

/// One scan (revolution or frame) of a LiDAR, points in the LiDAR's frame as measured. Arrays have
/// one value per point, or are empty where the sensor gives none. Vehicle drops points that are not
/// finite, at the origin, or outside VehicleOptions::range_m.
struct Scan {
  std::int64_t stamp_ns = 0;  ///< time of dt_s = 0
  std::vector<float> x_m, y_m, z_m;
  std::vector<float> intensity;     ///< empty: none
  std::vector<float> dt_s;          ///< seconds after stamp_ns, not below 0; empty: no point times
  std::vector<std::uint16_t> ring;  ///< index of the laser; empty: none
  std::uint16_t rings = 0;          ///< number of lasers of the sensor; 0: unknown
  bool deskewed = false;            ///< all points refer to the time of the last one

  [[nodiscard]] std::size_t size() const { return x_m.size(); }
};

/// One radio range between an antenna of one vehicle and one of another.
struct RangeMeasurement {
  std::int64_t stamp_ns = 0;
  std::string from, to;                           ///< vehicles
  std::uint8_t from_antenna = 0, to_antenna = 0;  ///< index in the vehicle's list of antennas
  double range_m = 0.0;
  double sigma_m = 0.0;         ///< 0: take the setting's
  double rssi_dbm = 0.0;        ///< 0: unknown
  double first_path_dbm = 0.0;  ///< 0: unknown
};

/// State of a peer. Ranges to a peer are used during its standstill: its antenna is then a
/// landmark. A beacon is a peer that never moves. Repeat the state at least once a second.
struct PeerState {
  std::int64_t stamp_ns = 0;
  std::string vehicle;
  bool standstill = false;
};

/// The data have ended: scans that wait for inertial data are processed without it.
struct EndOfData {};

/// The input of a Vehicle, in order of time: inertial samples and ranges by their stamp, a scan by
/// the time of its last point.
using Event = std::variant<ImuSample, Scan, RangeMeasurement, PeerState, EndOfData>;

}  // namespace rali
