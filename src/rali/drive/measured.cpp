#include "rali/drive/measured.hpp"

#include "rali/drive/ranges/range_latency.hpp"

namespace rali::drive {

void take_measured(const vehicle::Vehicle& vehicle, const vehicle::VehicleSettings& settings,
                   VehicleSummary& summary) {
  summary.input.range_latency =
      latency_by_motion(vehicle.range_stamp_offset(), settings.ranging.bias.tau_sigma_s);
  summary.imu_noise = vehicle.measured_noise();
  summary.imu_noise_stated = odometry::driving_noise(settings.odometry.imu_noise);
}

}  // namespace rali::drive
