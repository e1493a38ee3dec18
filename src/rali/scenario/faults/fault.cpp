#include "rali/scenario/faults/fault.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "rali/config/suggest.hpp"
#include "rali/io/files/text.hpp"
#include "rali/scenario/vehicle_names.hpp"

namespace rali::scenario {
namespace {

constexpr double kLatest_s = 36000.0;

tl::unexpected<Error> wrong(std::string_view text, std::string what, std::string remedy) {
  return fail(ErrorCode::kUsage, fmt::format("--fault {}", io::quoted(text, 60)), std::move(what),
              std::move(remedy));
}

std::string example() { return "Write KIND:VEHICLE@T0-T1, e.g. --fault gap:v1@30-35."; }

std::optional<FaultKind> kind_of(std::string_view name) {
  const auto found = std::find(kFaultNames.begin(), kFaultNames.end(), name);
  if (found == kFaultNames.end()) return std::nullopt;
  return static_cast<FaultKind>(found - kFaultNames.begin());
}

/// T0-T1, or T0 alone for faults without an end.
Result<std::pair<double, double>> parse_window(std::string_view text, std::string_view window,
                                               FaultKind kind) {
  const std::size_t dash = window.find('-', 1);
  const bool open = dash == std::string_view::npos;
  if (open && kind != FaultKind::kCutFile) {
    return wrong(text, fmt::format("{} is no span of time", io::quoted(window)), example());
  }
  const std::optional<double> from = io::parse_number(window.substr(0, dash));
  const std::optional<double> to =
      open ? std::optional<double>(kLatest_s) : io::parse_number(window.substr(dash + 1));
  if (!from || !to || !std::isfinite(*from) || !std::isfinite(*to)) {
    return wrong(text, fmt::format("{} is no span of time", io::quoted(window)), example());
  }
  if (*from < 0.0 || *to > kLatest_s) {
    return wrong(text, fmt::format("times lie between 0 and {:.0f} s after the start", kLatest_s),
                 example());
  }
  if (*from >= *to) return wrong(text, "the fault ends before it begins", "Give T0 < T1.");
  return std::pair<double, double>{*from, *to};
}

}  // namespace

Result<std::vector<Fault>> parse_fault(std::string_view text, int vehicles) {
  const std::size_t colon = text.find(':');
  const std::size_t at = text.find('@');
  if (colon == std::string_view::npos || at == std::string_view::npos || at < colon) {
    return wrong(text, "a fault has a kind, a vehicle and a span of time", example());
  }
  const std::string_view name = text.substr(0, colon);
  const std::optional<FaultKind> kind = kind_of(name);
  if (!kind) {
    const std::vector<std::string> known(kFaultNames.begin(), kFaultNames.end());
    const std::string near = config::nearest_name(name, known);
    return wrong(
        text, fmt::format("{} is no kind of fault", io::quoted(name)),
        fmt::format("{}Kinds: {}.", near.empty() ? "" : fmt::format("Did you mean '{}'? ", near),
                    fmt::join(known, ", ")));
  }
  const std::string vehicle(text.substr(colon + 1, at - colon - 1));
  const std::vector<std::string> names = vehicle_names(vehicles);
  const auto found = std::find(names.begin(), names.end(), vehicle);
  if (found == names.end() && vehicle != "all") {
    return wrong(text, fmt::format("{} is no vehicle", io::quoted(vehicle)),
                 fmt::format("Vehicles: {}, all.", fmt::join(names, ", ")));
  }
  const auto window = parse_window(text, text.substr(at + 1), *kind);
  if (!window) return tl::make_unexpected(window.error());
  std::vector<Fault> faults;
  for (int v = 0; v < vehicles; ++v) {
    if (vehicle != "all" && found - names.begin() != v) continue;
    faults.push_back({*kind, v, window->first, window->second});
  }
  return faults;
}

Result<std::vector<Fault>> parse_faults(const std::vector<std::string>& texts, int vehicles) {
  std::vector<Fault> faults;
  for (const std::string& text : texts) {
    const auto more = parse_fault(text, vehicles);
    if (!more) return more;
    faults.insert(faults.end(), more->begin(), more->end());
  }
  return faults;
}

double cover_depth_m(Rng& chance) {
  return kFaultCoverFrom_m - kFaultCoverDepth_m * std::log1p(-chance.uniform());
}

std::string fault_text(const Fault& fault) {
  const std::string_view name = kFaultNames[static_cast<std::size_t>(fault.kind)];
  if (fault.kind == FaultKind::kCutFile) {
    return fmt::format("{}:v{}@{:g}", name, fault.vehicle + 1, fault.t0_s);
  }
  return fmt::format("{}:v{}@{:g}-{:g}", name, fault.vehicle + 1, fault.t0_s, fault.t1_s);
}

}  // namespace rali::scenario
