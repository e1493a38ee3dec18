#include "rali/assess/limits.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "rali/io/files/old_names.hpp"
#include "rali/io/files/text.hpp"

namespace rali::assess {
namespace {

std::optional<double> track_value(const TrackScore& s, const std::string& name) {
  if (s.poses == 0) return std::nullopt;
  if (name == "ape_rmse_m") return s.ape_m.rmse;
  if (name == "ape_max_m") return s.ape_m.max;
  if (name == "drift_final_m" && s.drift) return s.drift->final_m;
  if (name == "drift_z_m" && s.drift && s.drift->z_m) return std::abs(*s.drift->z_m);
  // Never degenerate is the best case, not a missing figure.
  if (name == "along_degenerate_rmse_m" && s.degenerate) return s.degenerate->along_m.rmse;
  if (name == "nees_mean" && s.nees6) return s.nees6->mean;
  if (const auto distance_m = rpe_distance_of(name)) {
    for (const RpeScore& rpe : s.rpe) {
      if (rpe.distance_m == *distance_m && rpe.translation_m.count > 0) {
        return rpe.translation_m.rmse;
      }
    }
  }
  return std::nullopt;
}

/// Drift is defined per vehicle; the fleet's value is that of the worst vehicle.
std::optional<double> fleet_value(const Evaluation& e, const std::string& name) {
  if (!name.starts_with("drift_")) return track_value(e.fleet, name);
  std::optional<double> worst;
  for (const VehicleScore& v : e.vehicles) {
    const auto value = track_value(v.trajectory, name);
    if (!value) return std::nullopt;
    worst = std::max(worst.value_or(0.0), *value);
  }
  return worst;
}

std::optional<double> value_of(const Limit& limit, const Evaluation& e) {
  if (limit.name.starts_with("c2m_")) {
    if (!e.cloud || !e.cloud->to_mesh || e.cloud->to_mesh->within.count == 0) return std::nullopt;
    const eval::Statistics& s = e.cloud->to_mesh->within;
    return limit.name == "c2m_mean_m" ? s.mean : s.std;
  }
  if (limit.vehicle.empty()) return fleet_value(e, limit.name);
  for (const VehicleScore& v : e.vehicles) {
    if (v.name == limit.vehicle) return track_value(v.trajectory, limit.name);
  }
  return std::nullopt;
}

}  // namespace

const std::vector<std::string>& limit_names() {
  static const std::vector<std::string> names{
      "ape_rmse_m",    "ape_max_m", "rpe_10m_rmse_m",
      "drift_final_m", "drift_z_m", "along_degenerate_rmse_m",
      "c2m_mean_m",    "c2m_std_m", "nees_mean"};
  return names;
}

std::optional<double> rpe_distance_of(const std::string& name) {
  constexpr std::string_view kBegin = "rpe_", kEnd = "m_rmse_m";
  if (!name.starts_with(kBegin) || !name.ends_with(kEnd)) return std::nullopt;
  if (name.size() <= kBegin.size() + kEnd.size()) return std::nullopt;
  const auto value = io::parse_number(
      std::string_view(name).substr(kBegin.size(), name.size() - kBegin.size() - kEnd.size()));
  if (!value || !(*value > 0.0) || !std::isfinite(*value)) return std::nullopt;
  return value;
}

Result<Limit> parse_limit(const std::string& text) {
  const std::size_t equals = text.find('=');
  Limit limit;
  limit.text = text;
  limit.name = text.substr(0, equals);
  const std::size_t colon = limit.name.rfind(':');
  if (colon != std::string::npos) {
    limit.vehicle = limit.name.substr(0, colon);
    limit.name = limit.name.substr(colon + 1);
  }
  limit.name = io::current_name_of(limit.name);
  const auto& names = limit_names();
  const bool known = std::find(names.begin(), names.end(), limit.name) != names.end() ||
                     rpe_distance_of(limit.name).has_value();
  if (!known) {
    return fail(ErrorCode::kUsage, "--limit", io::quoted(limit.name) + " is no figure",
                fmt::format("Known are {}.", fmt::join(names, ", ")));
  }
  if (!limit.vehicle.empty() && limit.name.starts_with("c2m_")) {
    return fail(ErrorCode::kUsage, "--limit",
                io::quoted(text) + " asks for the map of one vehicle, but the map is everyone's");
  }
  const auto max = equals == std::string::npos
                       ? std::nullopt
                       : io::parse_number(std::string_view(text).substr(equals + 1));
  if (!max || !(*max >= 0.0) || !std::isfinite(*max)) {
    return fail(ErrorCode::kUsage, "--limit", io::quoted(text) + " has no number of at least 0",
                "Write it as ape_rmse_m=0.2 or v1:ape_rmse_m=0.2.");
  }
  limit.max = *max;
  return limit;
}

std::vector<std::string> broken_limits(const std::vector<Limit>& limits, const Evaluation& e) {
  std::vector<std::string> broken;
  for (const Limit& limit : limits) {
    const std::optional<double> value = value_of(limit, e);
    if (!value) {
      broken.push_back(
          fmt::format("limit {}: could not be checked, it was not measured", limit.text));
    } else if (!(*value <= limit.max)) {
      broken.push_back(fmt::format("limit {}: it is {:.4g}", limit.text, *value));
    }
  }
  return broken;
}

}  // namespace rali::assess
