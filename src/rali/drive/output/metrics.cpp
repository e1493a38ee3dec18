#include "rali/drive/output/metrics.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "rali/drive/version.hpp"

namespace rali::drive {
namespace {

using Json = nlohmann::ordered_json;

/// Rounded to `digits` decimals; null if not finite.
Json number(double value, int digits = 6) {
  if (!std::isfinite(value)) return nullptr;
  const double scale = std::pow(10.0, digits);
  const double rounded = std::round(value * scale) / scale;
  return rounded == 0.0 ? 0.0 : rounded;
}

Json vector3(const geometry::Vec3& v) { return {number(v.x()), number(v.y()), number(v.z())}; }

Json pose(const geometry::SE3& T) {
  Eigen::Quaterniond q(T.R);
  q.normalize();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  Json json;
  json["xyz_m"] = vector3(T.p);
  json["quat_xyzw"] = {number(q.x(), 9), number(q.y(), 9), number(q.z(), 9), number(q.w(), 9)};
  return json;
}

/// The 21 numbers of a symmetric matrix, row by row, as in .cov.csv; null without.
Json upper_triangle(const std::optional<geometry::Mat6>& cov) {
  if (!cov) return nullptr;
  Json json = Json::array();
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) json.push_back(number((*cov)(r, c), 12));
  }
  return json;
}

/// Pose of map on the site, and the residuals of the marks.
Json site_json(const SiteFrame& site) {
  Json json{{"yaw_rad", number(site.yaw_rad, 9)},
            {"xyz_m", vector3(site.p_site_map_m)},
            {"yaw_sigma_rad", number(site.yaw_sigma_rad, 9)},
            {"rms_m", number(site.rms_m)},
            {"marks", Json::array()}};
  for (const MarkResidual& mark : site.residuals) {
    json["marks"].push_back({{"vehicle", mark.vehicle},
                             {"stamp_s", number(mark.t.s(), 6)},
                             {"residual_m", vector3(mark.residual_site_m)}});
  }
  return json;
}

Json gaps_json(const InputGaps& gaps) {
  Json json;
  json["jumps"] = gaps.jumps;
  json["missing_s"] = number(gaps.missing_s, 3);
  json["late"] = gaps.late;
  json["nan_points"] = gaps.nan_points;
  json["no_time_points"] = gaps.no_time_points;
  json["imu_saturated"] = gaps.imu_saturated;
  json["repeated"] = gaps.repeated;
  json["imu_invalid"] = gaps.imu_invalid;
  json["imu_missing_s"] = number(gaps.imu_missing_s, 3);
  json["undecodable"] = gaps.undecodable;
  json["bytes_lost"] = gaps.bytes_lost;
  json["late_scans"] = gaps.late_scans;
  json["empty_scans"] = gaps.empty_scans;
  return json;
}

/// Statistics of the live poses; null as long as the vehicle was not joined.
Json live_json(const LiveTally& live) {
  if (live.poses == 0) return nullptr;
  Json json;
  json["poses"] = live.poses;
  json["t_joined_s"] = number(live.t_joined.s(), 6);
  json["steps"] = live.steps;
  json["step_max_m"] = number(live.largest.shift_m);
  json["step_max_reason"] = live.steps > 0 ? Json(live.largest.reason) : Json(nullptr);
  json["step_max_t_s"] = live.steps > 0 ? number(live.largest.t.s(), 6) : Json(nullptr);
  return json;
}

/// Null without inertial data; a value that was not measured is null.
Json imu_noise_json(const VehicleSummary& v) {
  if (!v.input.has_imu) return nullptr;
  const auto measured = [](const std::optional<double>& value) {
    return value ? number(*value, 9) : Json(nullptr);
  };
  return {{"accel_mps2_rthz", measured(v.imu_noise.accel_mps2_rthz)},
          {"accel_stated_mps2_rthz", number(v.imu_noise_stated.accel_mps2_rthz, 9)},
          {"gyro_radps_rthz", measured(v.imu_noise.gyro_radps_rthz)},
          {"gyro_stated_radps_rthz", number(v.imu_noise_stated.gyro_radps_rthz, 9)}};
}

Json vehicle_json(const VehicleSummary& v) {
  Json json;
  json["path_m"] = number(v.path_m, 3);
  json["scans"] = v.scans;
  json["scans_dropped"] = v.scans_dropped;
  json["keyframes"] = v.keyframes;
  json["degenerate_fraction"] = number(v.degenerate_fraction);
  json["degenerate_constrained_fraction"] = number(v.degenerate_held_fraction);
  json["sigma_median_m"] = number(v.sigma_median_m);
  json["sigma_max_m"] = number(v.sigma_max_m);
  json["diverged_s"] = number(v.diverged_s, 3);
  json["T_map_odom"] = pose(v.T_map_odom);
  json["T_map_odom"]["cov"] = upper_triangle(v.T_map_odom_cov);
  json["T_map_odom"]["levelled"] = v.levelled;
  json["T_map_odom"]["tilt_sigma_rad"] = number(v.tilt_sigma_rad, 9);
  json["live"] = live_json(v.live);
  json["T_body_lidar"] = pose(v.input.T_body_lidar);
  const LidarTimeOffset& offset = v.input.lidar_time_offset;
  json["time_offset_s"] = number(offset.value_s, 9);
  json["time_offset_sigma_s"] = offset.sigma_s ? number(*offset.sigma_s, 6) : Json(nullptr);
  json["time_offset_origin"] = offset.origin.empty() ? "settings" : offset.origin;
  const ClockOffset& clock = v.input.clock_offset;
  json["clock_offset_s"] = number(clock.value_s, 9);
  json["clock_offset_sigma_s"] = clock.sigma_s ? number(*clock.sigma_s, 6) : Json(nullptr);
  json["accel_scale"] = number(v.input.accel_scale);
  json["imu_noise"] = imu_noise_json(v);
  json["gaps"] = gaps_json(v.input.gaps);
  return json;
}

/// The joint estimate's bias between two vehicles, by their names "v1-v2"; with several antennas
/// the first pair. Null where the vehicles could not be joined.
const fleet::PairBias* joint_bias(const MapSummary& summary, const std::string& pair) {
  for (const fleet::PairBias& bias : summary.fleet.biases) {
    const std::string& a = summary.vehicles[bias.a.value].name;
    const std::string& b = summary.vehicles[bias.b.value].name;
    if (pair == a + '-' + b || pair == b + '-' + a) return &bias;
  }
  return nullptr;
}

/// Latency of one pair, from the motion of its two vehicles; null if neither observed it.
std::optional<RangeLatency> latency_of(const MapSummary& summary, const MapJob& job,
                                       const std::string& pair) {
  if (job.ranges.latency_s) return RangeLatency{*job.ranges.latency_s, {}};
  for (const VehicleSummary& a : summary.vehicles) {
    for (const VehicleSummary& b : summary.vehicles) {
      if (pair == a.name + '-' + b.name) {
        return combined(std::array{a.input.range_latency, b.input.range_latency});
      }
    }
  }
  return std::nullopt;
}

/// Rejected ranges by reason; reasons without ranges are left out.
Json ranges_json(const MapSummary& summary, const MapJob& job) {
  const RangeTally& ranges = summary.ranges;
  Json json{{"total", ranges.total}, {"used", ranges.used()}};
  json["rejected"] = Json::object();
  for (std::size_t i = 1; i < ranges.by_reason.size(); ++i) {
    if (ranges.by_reason[i] == 0) continue;
    json["rejected"][std::string(ranging::kRangeReasonNames[i])] = ranges.by_reason[i];
  }
  json["pairs"] = Json::object();
  for (const RangePair& pair : ranges.pairs) {
    // The vehicles' own estimates have a bias without its sigma.
    const fleet::PairBias* joint = joint_bias(summary, pair.name);
    const std::optional<RangeLatency> latency = latency_of(summary, job, pair.name);
    json["pairs"][pair.name] = {
        {"total", pair.total},
        {"used", pair.used},
        {"bias_m", number(joint ? joint->bias_m : pair.bias_m)},
        {"bias_sigma_m", joint ? number(joint->sigma_m) : Json(nullptr)},
        {"residual_std_m", number(pair.residual_std_m)},
        {"latency_s", latency ? number(latency->value_s) : Json(nullptr)},
        {"latency_sigma_s",
         latency && latency->sigma_s ? number(*latency->sigma_s) : Json(nullptr)}};
  }
  return json;
}

/// Which vehicles share a frame, and the measurements that connect them.
Json fleet_json(const MapSummary& summary) {
  const fleet::FleetEstimate& fleet = summary.fleet;
  Json json{{"groups", Json::array()}, {"frames", Json::object()}};
  for (const std::vector<VehicleId>& group : fleet.groups) {
    Json names = Json::array();
    for (const VehicleId id : group) names.push_back(summary.vehicles[id.value].name);
    json["groups"].push_back(names);
  }
  for (const fleet::VehicleFrame& f : fleet.frames) {
    const std::string_view by = f.decided_by ? decided_by_text(*f.decided_by) : "";
    json["frames"][summary.vehicles[f.vehicle.value].name] = {{"decided_by", by},
                                                              {"sigma_m", number(f.sigma_m)},
                                                              {"sigma_rad", number(f.sigma_rad)},
                                                              {"waits_for", f.waits_for}};
  }
  const auto accepted = std::count_if(fleet.loops.begin(), fleet.loops.end(),
                                      [](const fleet::LoopVerdict& l) { return l.accepted; });
  json["loops_accepted"] = accepted;
  json["loops_refused"] = static_cast<std::ptrdiff_t>(fleet.loops.size()) - accepted;
  json["rounds"] = summary.rounds.size();
  return json;
}

std::string sentence(const Finding& f) {
  std::string text = f.text;
  for (const std::string* part : {&f.effect, &f.remedy}) {
    if (part->empty()) continue;
    if (!text.ends_with('.')) text += '.';
    text += ' ' + *part;
  }
  return text;
}

}  // namespace

std::string_view status_name(RunStatus status) {
  switch (status) {
    case RunStatus::kComplete:
      return "complete";
    case RunStatus::kPartial:
      return "partial";
    case RunStatus::kInterrupted:
      return "interrupted";
    case RunStatus::kFailed:
      break;
  }
  return "failed";
}

std::string metrics_text(const MapSummary& summary, const MapJob& job) {
  Json json;
  json["schema"] = 2;
  json["rali"] = version();
  json["status"] = status_name(summary.status);
  bool any = false;
  Time t_start, t_end;
  for (const VehicleSummary& v : summary.vehicles) {
    if (v.input.scans == 0) continue;
    t_start = any ? std::min(t_start, v.input.t_start) : v.input.t_start;
    t_end = any ? std::max(t_end, v.input.t_end) : v.input.t_end;
    any = true;
  }
  json["t_start_s"] = any ? number(t_start.s(), 6) : Json(nullptr);
  json["t_end_s"] = any ? number(t_end.s(), 6) : Json(nullptr);
  json["vehicles"] = Json::object();
  for (const VehicleSummary& v : summary.vehicles) json["vehicles"][v.name] = vehicle_json(v);
  json["fleet"] = fleet_json(summary);
  json["ranges"] = ranges_json(summary, job);
  json["map"] = {{"points", summary.map_points},
                 {"voxel_m", number(job.map.voxel_m)},
                 {"thickness_m", number(summary.map_thickness_m)}};
  if (summary.site) json["site"] = site_json(*summary.site);
  json["checks"] = {{"keyframes", summary.checks.keyframes},
                    {"keyframes_checked", summary.checks.keyframes_checked},
                    {"contradictions", summary.checks.contradictions}};
  json["warnings"] = Json::array();
  for (const Finding& f : summary.findings) {
    if (f.severity == Severity::kInfo) continue;
    Json warning{{"id", f.id}, {"vehicle", f.vehicle}, {"text", sentence(f)}};
    if (f.t.ns > 0) {
      warning["t_start_s"] = number(f.t.s(), 6);
      warning["t_end_s"] = number(std::max(f.t, f.t_end).s(), 6);
    }
    json["warnings"].push_back(std::move(warning));
  }
  // Texts may hold bytes of topic names that are not UTF-8: replaced instead of throwing.
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace rali::drive
