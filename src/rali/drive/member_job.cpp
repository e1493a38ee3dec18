#include "rali/drive/member_job.hpp"

#include "rali/drive/open_events.hpp"
#include "rali/drive/ranges/range_files.hpp"

namespace rali::drive {

std::vector<std::string> vehicle_names(const MapJob& job) {
  std::vector<std::string> names;
  for (const VehicleJob& vehicle : job.vehicles) names.push_back(vehicle.input.vehicle);
  return names;
}

VehicleJob member_job(const MapJob& job, std::size_t index,
                      const std::shared_ptr<const RangeOptions>& ranges) {
  VehicleJob member = job.vehicles[index];
  member.input.strict |= job.strict;
  member.input.turning_follows = !job.facts;
  member.input.self = VehicleId{static_cast<std::uint16_t>(index)};
  member.input.ranges = ranges;
  return member;
}

vehicle::VehicleSettings settings_with(vehicle::VehicleSettings settings,
                                       const InputReport& input) {
  settings.name = input.vehicle;
  settings.has_imu = input.has_imu;
  settings.calibration.T_body_lidar = input.T_body_lidar;
  settings.calibration.T_body_imu = input.T_body_imu;
  return settings;
}

double data_seconds(const MapSummary& summary) {
  double sum_s = 0.0;
  for (const VehicleSummary& v : summary.vehicles) {
    sum_s += seconds_between(v.input.t_start, v.input.t_end);
  }
  return sum_s;
}

bool is_connected(const fleet::FleetEstimate& estimate) { return estimate.groups.size() <= 1; }

Result<std::vector<InputReport>> plan_map(const MapJob& job) {
  std::vector<InputReport> reports;
  const auto ranges = std::make_shared<const RangeOptions>(job.ranges);
  for (std::size_t i = 0; i < job.vehicles.size(); ++i) {
    const Result<std::unique_ptr<ReportedSource>> source = open_events(member_job(job, i, ranges));
    if (!source) return tl::make_unexpected(source.error());
    reports.push_back((*source)->report());
  }
  if (const auto files = read_range_files(job.ranges); !files) {
    return tl::make_unexpected(files.error());
  }
  return reports;
}

}  // namespace rali::drive
