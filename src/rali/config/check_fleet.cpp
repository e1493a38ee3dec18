#include "rali/config/check_fleet.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "rali/config/codecs.hpp"
#include "rali/config/suggest.hpp"

namespace rali::config {
namespace {

class FleetChecker {
 public:
  FleetChecker(const FleetConfig& config, const std::string& name) : config_(config), name_(name) {
    for (const VehicleConfig& vehicle : config.vehicles) names_.push_back(vehicle.name);
  }

  [[nodiscard]] Status check() const {
    for (const VehicleConfig& vehicle : config_.vehicles) {
      const std::string key = "vehicles." + vehicle.name;
      if (vehicle.recordings.empty()) {
        return fail(ErrorCode::kUsage, name_, key + " has no recording",
                    fmt::format("Write {}.recording.", key));
      }
      if (Status status = ordered(key + ".lidar.range_m", vehicle.lidar.range_m); !status) {
        return status;
      }
    }
    if (Status status = ordered("ranges.limits_m", config_.ranges.limits_m); !status) return status;
    if (Status status = ordered("output.grid.z_m", config_.settings.map.grid.z_m); !status)
      return status;
    if (Status status = check_priors(); !status) return status;
    if (Status status = check_sources(); !status) return status;
    return check_pairs();
  }

 private:
  [[nodiscard]] std::string where(const std::string& key) const {
    const auto origin = config_.origins.find(key);
    return origin == config_.origins.end() ? name_ : origin->second;
  }

  [[nodiscard]] Status ordered(const std::string& key, const std::array<double, 2>& bounds) const {
    if (bounds[0] < bounds[1]) return {};
    return fail(
        ErrorCode::kUsage, where(key),
        fmt::format("{} is {}: the first must be below the second", key, encode_list(bounds)));
  }

  [[nodiscard]] Status known(const std::string& key, const std::string& vehicle) const {
    if (std::find(names_.begin(), names_.end(), vehicle) != names_.end()) return {};
    return fail(ErrorCode::kUsage, where(key),
                fmt::format("{}: '{}' is no vehicle ({})", key, vehicle, fmt::join(names_, ", ")),
                nearest_name(vehicle, names_).empty() ? "" : suggestion(vehicle, names_));
  }

  [[nodiscard]] Status check_priors() const {
    for (const PriorConfig& prior : config_.priors) {
      if (Status status = known("priors", prior.vehicle); !status) return status;
      if (prior.relative_to.empty()) continue;
      if (Status status = known("priors", prior.relative_to); !status) return status;
      if (prior.relative_to == prior.vehicle) {
        return fail(ErrorCode::kUsage, where("priors"),
                    fmt::format("priors: '{}' is given relative to itself", prior.vehicle));
      }
    }
    return {};
  }

  [[nodiscard]] Status check_sources() const {
    for (const RangeSource& source : config_.ranges.sources) {
      if (!source.vehicle.empty()) {
        if (Status status = known("ranges.sources", source.vehicle); !status) return status;
      }
      for (const auto& id : source.ids) {
        if (Status status = check_radio(id.second); !status) return status;
      }
    }
    return {};
  }

  [[nodiscard]] Status check_radio(const RadioName& name) const {
    if (Status status = known("ranges.sources", name.vehicle); !status) return status;
    if (name.antenna.empty()) return {};
    const auto vehicle =
        std::find_if(config_.vehicles.begin(), config_.vehicles.end(),
                     [&](const VehicleConfig& v) { return v.name == name.vehicle; });
    const bool has = std::any_of(vehicle->antennas.begin(), vehicle->antennas.end(),
                                 [&](const AntennaConfig& a) { return a.name == name.antenna; });
    if (has) return {};
    return fail(ErrorCode::kUsage, where("ranges.sources"),
                fmt::format("ranges.sources: '{}' has no antenna '{}'", name.vehicle, name.antenna),
                fmt::format("Name it in vehicles.{}.antennas.", name.vehicle));
  }

  /// "v1-v2": names may hold a '-', so every split is tried.
  [[nodiscard]] Status check_pairs() const {
    for (const auto& pair : config_.ranges.pair_bias_m) {
      const std::string& text = pair.first;
      bool fits = false;
      for (std::size_t at = text.find('-'); at != std::string::npos; at = text.find('-', at + 1)) {
        fits = fits || (known("", text.substr(0, at)) && known("", text.substr(at + 1)));
      }
      if (fits) continue;
      return fail(ErrorCode::kUsage, where("ranges.bias_m"),
                  fmt::format("ranges.bias_m: '{}' is no pair of vehicles ({})", text,
                              fmt::join(names_, ", ")),
                  "Write for instance v1-v2.");
    }
    return {};
  }

  const FleetConfig& config_;
  const std::string& name_;
  std::vector<std::string> names_;
};

}  // namespace

Status check_fleet(const FleetConfig& config, const std::string& name) {
  return FleetChecker(config, name).check();
}

}  // namespace rali::config
