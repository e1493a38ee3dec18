#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "rali/base/finding.hpp"
#include "rali/base/result.hpp"
#include "rali/drive/live/live_map.hpp"
#include "rali/drive/vehicle_run.hpp"
#include "rali/fleet/centre/estimate.hpp"

namespace rali::drive {

/// Findings of `rali map` about a run as a whole.

/// D09: the gyro's rotation differs from the LiDAR's.
[[nodiscard]] std::optional<Finding> gyro_finding(const VehicleRun& run, const InputReport& input);

/// D10: noise of the inertial data that the settings state far too low or too high.
[[nodiscard]] FindingList noise_findings(const VehicleSummary& vehicle);

[[nodiscard]] Finding no_pose_finding(const std::string& vehicle, const InputReport& input);
/// Start poses contradicted by all other measurements; one finding for each vehicle outside the
/// largest group, with what would join it.
[[nodiscard]] FindingList fleet_findings(const fleet::FleetEstimate& estimate,
                                         const std::vector<std::string>& names);
[[nodiscard]] Finding no_map_finding();
/// --imu-rate without inertial data.
[[nodiscard]] Finding no_imu_rate_finding(const std::string& vehicle);
/// A mark that cannot be used, and a map without site coordinates.
[[nodiscard]] Finding lost_mark_finding(const std::string& vehicle, Time t, bool in_map);
[[nodiscard]] Finding no_site_finding(const Error& error);
/// How well the marks of the site agree with the map.
[[nodiscard]] Finding site_finding(const SiteFrame& site);

/// A vehicle whose live poses were in a frame that later facts contradict.
[[nodiscard]] Finding withdrawal_finding(const Withdrawal& withdrawal, const std::string& vehicle);

/// A vehicle whose data could not be read to their end, while those of others could.
[[nodiscard]] Finding failed_finding(const std::string& vehicle, const Error& error);

}  // namespace rali::drive
