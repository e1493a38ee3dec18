#pragma once

#include <string>

#include "rali/sensor/lidar_scan.hpp"
#include "rali/wire/byte_writer.hpp"
#include "rali/wire/cloud_format.hpp"

namespace rali::wire {

/// Layouts of PointCloud2 as the makers' drivers send them (users.md section 3).
enum class CloudStyle {
  kVelodyne,     ///< 22 bytes: xyzi float32, ring uint16 @16, time float32 s @18 (unaligned)
  kVelodynePcl,  ///< 32 bytes: intensity @16, ring @20, time @24
  kOuster,       ///< 48 bytes: intensity @16, t uint32 ns @20, ring uint16 @26
  kRoboSense,    ///< 26 bytes: ring uint16 @16, timestamp float64 s absolute @18; also Hesai
  kLivox,        ///< 26 bytes: tag, line uint8 @16 @17, timestamp float64 ns absolute @18
  kXyzi          ///< 16 bytes: no time, no ring
};

/// A cloud that owns its bytes.
struct PackedCloud {
  CloudView view;  ///< view.data points into `data`
  Bytes data;
};

/// A scan as a PointCloud2 of one row. Relative times count from the end of the scan given by
/// `header_stamp`: with kEnd they are negative and the stamp is t_end, else the stamp is t_start.
[[nodiscard]] PackedCloud pack_cloud(const sensor::LidarScan& scan, std::string frame_id,
                                     CloudStyle style,
                                     HeaderStamp header_stamp = HeaderStamp::kStart,
                                     bool big_endian = false);

}  // namespace rali::wire
