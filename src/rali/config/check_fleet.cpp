#include "rali/config/check_fleet.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "rali/config/codecs.hpp"
#include "rali/config/suggest.hpp"
#include "rali/geometry/so3.hpp"

namespace rali::config {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

using NamePair = std::pair<std::string, std::string>;

/// The same files under any path; empty if there are none.
std::string shared_recording(const VehicleConfig& a, const VehicleConfig& b) {
  for (const std::string& one : a.recordings) {
    for (const std::string& other : b.recordings) {
      std::error_code error;
      if (one == other || std::filesystem::equivalent(one, other, error)) return other;
    }
  }
  return {};
}

bool ends_before(const VehicleConfig& a, const VehicleConfig& b) {
  return a.duration_s > 0.0 && a.start_s + a.duration_s <= b.start_s;
}

class FleetChecker {
 public:
  FleetChecker(const FleetConfig& config, const std::string& name) : config_(config), name_(name) {
    for (const VehicleConfig& vehicle : config.vehicles) names_.push_back(vehicle.name);
  }

  [[nodiscard]] Status check(bool live) const {
    for (const VehicleConfig& vehicle : config_.vehicles) {
      const std::string key = "vehicles." + vehicle.name;
      if (vehicle.recordings.empty() && !live) {
        return fail(ErrorCode::kUsage, name_, key + " has no recording",
                    fmt::format("Write {}.recording.", key));
      }
      if (Status status = ordered(key + ".lidar.range_m", vehicle.lidar.cloud.range_m); !status) {
        return status;
      }
    }
    if (Status status = ordered("ranges.limits_m", config_.ranges.limits_m); !status) return status;
    if (Status status = ordered("output.grid.z_m", config_.settings.map.grid.z_m); !status)
      return status;
    if (Status status = check_recordings(); !status) return status;
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
      if (Status status = known("priors", base_of(prior)); !status) return status;
      if (base_of(prior) == prior.vehicle) {
        return fail(ErrorCode::kUsage, where("priors"),
                    fmt::format("priors: '{}' is given relative to itself", prior.vehicle));
      }
    }
    for (std::size_t j = 0; j < config_.priors.size(); ++j) {
      for (std::size_t i = 0; i < j; ++i) {
        if (Status status = agree(config_.priors[i], config_.priors[j]); !status) return status;
      }
    }
    return check_all_placed();
  }

  /// With commit rule kAtSize, as in the paper, only a prior can initialise a vehicle's start pose.
  [[nodiscard]] Status check_all_placed() const {
    const fleet::FleetSettings& fleet = config_.settings.fleet;
    if (!fleet.join || fleet.init.commit.rule != fleet::CommitRule::kAtSize) return {};
    std::set<std::string> placed = {names_.front()};
    for (std::size_t pass = 0; pass < config_.priors.size(); ++pass) {
      for (const PriorConfig& prior : config_.priors) {
        if (!placed.contains(prior.vehicle) && !placed.contains(base_of(prior))) continue;
        placed.insert({prior.vehicle, base_of(prior)});
      }
    }
    for (const std::string& name : names_) {
      if (placed.contains(name)) continue;
      return fail(ErrorCode::kUsage, where("priors"),
                  fmt::format("priors: none says where '{}' starts; preset paper places nobody "
                              "without one",
                              name),
                  "Measure it and write it under priors, or map with preset robust.");
    }
    return {};
  }

  /// Parts of one recording, or two sensors in it, may be two vehicles; identical scans may not.
  /// With separate clocks parts may overlap: they are joined by places that both have observed.
  [[nodiscard]] Status check_recordings() const {
    for (std::size_t j = 0; j < config_.vehicles.size(); ++j) {
      for (std::size_t i = 0; i < j; ++i) {
        const VehicleConfig &a = config_.vehicles[i], &b = config_.vehicles[j];
        const bool days = config_.clock == Clock::kSeparate && a.start_s != b.start_s;
        const bool apart =
            days || a.lidar.topic != b.lidar.topic || ends_before(a, b) || ends_before(b, a);
        const std::string twice = apart ? "" : shared_recording(a, b);
        if (twice.empty()) continue;
        return fail(
            ErrorCode::kUsage, where("vehicles." + b.name + ".recording"),
            fmt::format("{} is the recording of both '{}' and '{}'", twice, a.name, b.name),
            "Give each its own, or tell them apart by lidar.topic or by start_s and duration_s.");
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

  /// Checks that two start poses of one pair agree within five sigma of their difference.
  [[nodiscard]] Status agree(const PriorConfig& a, const PriorConfig& b) const {
    constexpr double kSigmas = 5.0;
    const PlacedPrior one = placed(a), two = placed(b);
    if (one.base != two.base || one.vehicle != two.vehicle) return {};
    const double off_m = (one.T.p - two.T.p).norm();
    const double off_deg = geometry::so3_log(one.T.R.transpose() * two.T.R).norm() / kRadPerDeg;
    if (off_m <= kSigmas * std::hypot(one.sigma_m, two.sigma_m) &&
        off_deg <= kSigmas * std::hypot(a.sigma_deg, b.sigma_deg)) {
      return {};
    }
    return fail(
        ErrorCode::kUsage, where("priors"),
        fmt::format("priors: two of '{}' relative to '{}' differ by {:.1f} m, {:.0f} deg",
                    b.vehicle, one.base == b.vehicle ? one.vehicle : one.base, off_m, off_deg),
        "Remove the wrong one, or raise sigma_m and sigma_deg.");
  }

  struct PlacedPrior {
    std::string base, vehicle;  ///< in order of their names
    geometry::SE3 T;
    double sigma_m = 0.0;
  };

  [[nodiscard]] const std::string& base_of(const PriorConfig& prior) const {
    return prior.relative_to.empty() ? names_.front() : prior.relative_to;
  }

  [[nodiscard]] PlacedPrior placed(const PriorConfig& prior) const {
    PlacedPrior p{base_of(prior),
                  prior.vehicle,
                  {geometry::rotation_from_rpy(0.0, 0.0, prior.yaw_deg * kRadPerDeg), prior.p_m},
                  prior.sigma_m};
    if (p.base < p.vehicle) return p;
    std::swap(p.base, p.vehicle);
    p.T = p.T.inverse();
    // For the inverse pose, an error of heading moves the position too.
    p.sigma_m = std::hypot(p.sigma_m, prior.p_m.norm() * prior.sigma_deg * kRadPerDeg);
    return p;
  }

  /// "v1-v2": names may hold a '-', so every split is tried.
  [[nodiscard]] std::optional<NamePair> pair_of(const std::string& text) const {
    for (std::size_t at = text.find('-'); at != std::string::npos; at = text.find('-', at + 1)) {
      const std::string a = text.substr(0, at), b = text.substr(at + 1);
      if (a != b && known("", a) && known("", b)) return NamePair(std::minmax(a, b));
    }
    return std::nullopt;
  }

  [[nodiscard]] Status check_pairs() const {
    std::set<NamePair> seen;
    for (const auto& [text, bias_m] : config_.ranges.pair_bias_m) {
      const std::optional<NamePair> pair = pair_of(text);
      if (!pair) {
        return fail(ErrorCode::kUsage, where("ranges.bias_m"),
                    fmt::format("ranges.bias_m: '{}' is no pair of vehicles ({})", text,
                                fmt::join(names_, ", ")),
                    "Write for instance v1-v2.");
      }
      if (!seen.insert(*pair).second) {
        return fail(ErrorCode::kUsage, where("ranges.bias_m"),
                    fmt::format("ranges.bias_m: '{}' is given the other way round, too", text),
                    "Both ways have one bias: remove one.");
      }
    }
    return {};
  }

  const FleetConfig& config_;
  const std::string& name_;
  std::vector<std::string> names_;
};

}  // namespace

Status check_fleet(const FleetConfig& config, const std::string& name, bool live) {
  return FleetChecker(config, name).check(live);
}

}  // namespace rali::config
