#include "rali/report/section/checks.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "rali/report/internal/html.hpp"
#include "rali/report/section/degenerate_words.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

/// A larger fraction of the trajectory, degenerate and without ranges, is flagged.
constexpr double kUnheldFraction = 0.02;
constexpr double kLargeSigma_m = 0.5;
/// Mean NEES above this multiple of its expectation: the covariances are overconfident.
constexpr double kNeesFactorMax = 2.0;
/// Below this multiple the covariances are far too large, which is flagged too.
constexpr double kNeesFactorMin = 0.1;
/// Fewer values within the 95 % bounds than this fraction: also overconfident.
constexpr double kWithin95Min = 0.85;
/// With a smaller fraction of keyframes able to contradict the map, the check is not passed.
constexpr double kCheckedMin = 0.8;

std::string status_words(const RunData& run) {
  if (run.status == "complete") return "complete";
  if (run.status == "partial") return "done in part, see the findings; what is there is valid";
  if (run.status == "interrupted") return "stopped before the end of the data";
  if (run.status == "failed") return "failed; what is whole was kept";
  if (run.status == "running") return "still running, or killed";
  return "not known";
}

Check run_check(const RunData& run) {
  const CheckState state = run.status == "complete"                            ? CheckState::kGood
                           : run.status == "failed" || run.status == "running" ? CheckState::kBad
                           : run.status.empty() ? CheckState::kNotChecked
                                                : CheckState::kLook;
  return {state, "the run", status_words(run)};
}

/// Some drivers send points for missing returns: these are no gap.
bool is_harmless(std::string_view key) { return key == "nan_points"; }

Check input_check(const RunData& run) {
  Check check{CheckState::kNotChecked, "input", "not known"};
  std::string found;
  for (const VehicleView& v : run.vehicles) {
    if (!v.numbers.gaps.empty() && check.state == CheckState::kNotChecked) {
      check.state = CheckState::kGood;
    }
    const auto add = [&](double value, std::string_view words) {
      if (value <= 0.0) return;
      check.state = CheckState::kLook;
      found += fmt::format("{}{}: {} {}", found.empty() ? "" : "; ", escaped(v.name),
                           value == std::floor(value) ? counted(value) : fixed(value, 2), words);
    };
    for (const auto& [key, value] : v.numbers.gaps) {
      if (!is_harmless(key)) add(value, escaped(gap_words(key)));
    }
    add(v.numbers.scans_dropped.value_or(0.0), "scans without a pose");
  }
  if (check.state == CheckState::kGood) check.found = "no gaps, nothing damaged, no scan dropped";
  if (check.state == CheckState::kLook) check.found = found;
  return check;
}

Check divergence_check(const RunData& run) {
  Check check{CheckState::kNotChecked, "odometry", "not known"};
  double diverged_s = 0.0;
  for (const VehicleView& v : run.vehicles) {
    if (!v.numbers.diverged_s) continue;
    check.state = CheckState::kGood;
    diverged_s += *v.numbers.diverged_s;
  }
  if (check.state == CheckState::kNotChecked) return check;
  check.found = "no divergence detected";
  if (diverged_s <= 0.0) return check;
  check.state = CheckState::kBad;
  check.found = fmt::format("diverged for {} s: cut from the map", fixed(diverged_s, 1));
  return check;
}

/// The vehicle with the largest degenerate and unconstrained fraction; null: none.
const VehicleView* least_held(const RunData& run) {
  const VehicleView* worst = nullptr;
  for (const VehicleView& v : run.vehicles) {
    const double fraction = unheld_fraction(v);
    if (fraction > 0.0 && (worst == nullptr || fraction > unheld_fraction(*worst))) worst = &v;
  }
  return worst;
}

std::string unheld_found(const VehicleView& v) {
  const std::string words = unheld_words(v);
  if (v.degenerate_path.known && !words.empty()) return escaped(v.name) + ": " + words;
  return fmt::format("{}: {} of its path degenerate and constrained by {}", escaped(v.name),
                     percent(unheld_fraction(v)), v.degenerate_path.known ? "nothing" : "no range");
}

Check degenerate_check(const RunData& run) {
  Check check{CheckState::kNotChecked, "degenerate directions", "not known"};
  std::size_t known = 0, degenerate = 0;
  for (const VehicleView& v : run.vehicles) {
    known += blindness_known(v) ? 1 : 0;
    degenerate += was_degenerate(v) ? 1 : 0;
  }
  if (known == 0) return check;
  if (degenerate == 0) {
    // Files of a killed run cover only a part of it.
    if (known == run.vehicles.size() && run.metrics_known) {
      return {CheckState::kGood, check.what, "none: every direction is constrained"};
    }
    check.found =
        fmt::format("known for {} of {} vehicles: none there", known, run.vehicles.size());
    return check;
  }
  const VehicleView* worst = least_held(run);
  if (worst == nullptr) {
    return {CheckState::kLook, check.what, "met, and constrained by ranges or inertia everywhere"};
  }
  const bool far_off = worst->degenerate_path.peak_nothing.off_m > kLargeSigma_m;
  return {far_off ? CheckState::kBad : CheckState::kLook, check.what, unheld_found(*worst)};
}

Check frame_check(const RunData& run) {
  if (run.vehicles.size() < 2) {
    return {CheckState::kNotChecked, "common frame", "one vehicle: nothing to join"};
  }
  if (run.groups.empty()) return {CheckState::kNotChecked, "common frame", "not known"};
  if (run.groups.size() == 1) {
    return {CheckState::kGood, "common frame",
            fmt::format("all {} vehicles in one frame", run.vehicles.size())};
  }
  return {
      CheckState::kLook, "common frame",
      fmt::format("{} frames: vehicles of different frames cannot be compared", run.groups.size())};
}

Check range_check(const RunData& run) {
  const double total = run.ranges.total.value_or(0.0), used = run.ranges.used.value_or(0.0);
  if (total <= 0.0) {
    return {CheckState::kNotChecked, "ranges",
            ranges_unused(run).empty() ? "none were used" : "given, but none was used"};
  }
  // Duplicate or unneeded ranges are no fault.
  double faulty = total - used;
  for (const auto& [reason, n] : run.ranges.rejected) {
    if (reason == "duplicate" || reason == "not_needed") faulty -= n;
  }
  return {used > 0.0 && used >= faulty ? CheckState::kGood : CheckState::kLook, "ranges",
          fmt::format("{} used, {} not", counted(used), counted(total - used))};
}

Check loop_check(const RunData& run) {
  const double loops = run.loops_accepted.value_or(0.0);
  if (loops <= 0.0) {
    return {CheckState::kNotChecked, "loops", "none closed: drift was not checked by coming back"};
  }
  return {CheckState::kGood, "loops",
          fmt::format("{} closed, {} refused", counted(loops),
                      counted(run.loops_refused.value_or(0.0)))};
}

/// The vehicle with the largest mean NEES of a kind.
std::string worst_of(const RunData& run, const std::string& kind) {
  const VehicleView* worst = nullptr;
  double maximum = 0.0;
  for (const VehicleView& v : run.vehicles) {
    const Number nees = measured(run, "vehicles." + v.name + ".trajectory." + kind + ".mean");
    if (nees && *nees > maximum) maximum = *nees, worst = &v;
  }
  return worst == nullptr || run.vehicles.size() < 2 ? "" : ", most of all " + escaped(worst->name);
}

/// The fault in the covariances; empty: none.
std::string covariance_fault(const RunData& run) {
  for (const char* kind : {"nees_pose", "nees_position"}) {
    const std::string path = std::string("fleet.trajectory.") + kind;
    const Number nees = measured(run, path + ".mean");
    const Number expected = measured(run, path + ".expected_mean");
    const bool pose = std::string_view(kind) == "nees_pose";
    if (nees && expected && *nees > kNeesFactorMax * *expected) {
      return fmt::format(
          "errors of the {} are {} times the stated sigma (rms){}: the covariance is "
          "too small",
          pose ? "pose" : "position", ratio_text(nees, expected), worst_of(run, kind));
    }
    const Number within = measured(run, path + ".fraction_within_95");
    if (within && *within < kWithin95Min) {
      return fmt::format("only {} of the poses lie within their 95 % bounds", percent(within));
    }
  }
  return {};
}

Check truth_check(const RunData& run) {
  const Number ape = truth_error(run);
  if (!ape) return {CheckState::kNotChecked, "against ground truth", "not evaluated"};
  const std::string size = metres(ape) + " (APE rmse)";
  // The acceptable error is up to the reader; whether it was predicted can be checked.
  const Number nees = measured(run, "fleet.trajectory.nees_position.mean");
  const Number expected = measured(run, "fleet.trajectory.nees_position.expected_mean");
  if (!nees && !measured(run, "fleet.trajectory.nees_pose.mean")) {
    return {CheckState::kNotChecked, "against ground truth",
            size + "; no covariances to compare with"};
  }
  if (const std::string fault = covariance_fault(run); !fault.empty()) {
    return {CheckState::kLook, "against ground truth", size + "; " + fault};
  }
  const bool far_below = nees && expected && *nees < kNeesFactorMin * *expected;
  return {CheckState::kGood, "against ground truth",
          size + (far_below ? ", far less than stated: the covariance is too large"
                            : ", no more than the stated covariance allows")};
}

/// The fraction of the map that its own scans could contradict, and whether they did.
Check map_check(const RunData& run) {
  Check check{CheckState::kNotChecked, "map against its scans", "not known"};
  const SelfCheck& c = run.self_check;
  if (!c.keyframes || !c.checked || *c.keyframes <= 0.0) return check;
  const std::string part = fmt::format("{} of {} keyframes see enough walls to contradict the map",
                                       counted(c.checked), counted(c.keyframes));
  if (c.contradictions.value_or(0.0) > 0.0) {
    return {CheckState::kBad, check.what,
            fmt::format("{}; contradictions: {}", part, counted(c.contradictions))};
  }
  if (*c.checked <= 0.0) {
    check.found = "no keyframe sees enough walls to contradict the map";
  } else {
    check.state = *c.checked < kCheckedMin * *c.keyframes ? CheckState::kLook : CheckState::kGood;
    check.found = part + "; none does";
  }
  return check;
}

std::string uncertainty_of_status(const RunData& run) {
  if (run.status == "interrupted") {
    return fmt::format("the run was stopped at {} s: later data are not mapped.",
                       fixed(last_time_s(run), 0));
  }
  if (run.status == "failed" || run.status == "running") {
    return "the run did not reach its end: outputs are missing or cover a part of the data.";
  }
  return {};
}

std::string names_of_map(const RunData& run) {
  std::vector<std::string> names;
  for (const VehicleView& v : run.vehicles) {
    if (v.in_map) names.push_back(v.name);
  }
  return names_text(names);
}

/// The vehicle with the longest degenerate and unconstrained distance.
std::string uncertainty_of_degenerate(const RunData& run) {
  const VehicleView* worst = least_held(run);
  if (worst == nullptr || unheld_fraction(*worst) <= kUnheldFraction) return {};
  std::string text = unheld_found(*worst) +
                     "; the map may be too long or too short there, although its walls look "
                     "straight and thin";
  if (const Number largest = largest_error(run)) {
    text += fmt::format("; the largest error against ground truth is {}", metres(largest));
  }
  return text + '.';
}

std::string uncertainty_of_vehicles(const RunData& run) {
  for (const VehicleView& v : run.vehicles) {
    if (v.numbers.diverged_s.value_or(0.0) > 0.0) {
      return fmt::format("{} diverged for {} s; that stretch is missing in the map.",
                         escaped(v.name), fixed(v.numbers.diverged_s, 1));
    }
  }
  if (run.map_points.value_or(0.0) <= 0.0) return "there is no map.";
  if (run.groups.size() > 1) {
    return fmt::format(
        "the vehicles are in {} frames that are not joined: map.* holds {} alone, and where the "
        "others were in it is not known.",
        run.groups.size(), names_of_map(run));
  }
  if (const std::string degenerate = uncertainty_of_degenerate(run); !degenerate.empty())
    return degenerate;
  for (const VehicleView& v : run.vehicles) {
    if (v.numbers.sigma_max_m.value_or(0.0) <= kLargeSigma_m) continue;
    const Number largest = largest_error(run);
    if (largest && truth_check(run).state == CheckState::kGood) continue;
    return fmt::format("the position of {} has an expected error of up to {} (1 sigma).",
                       escaped(v.name), metres(v.numbers.sigma_max_m));
  }
  return {};
}

}  // namespace

std::string ratio_text(const Number& nees, const Number& expected) {
  if (!nees || !expected || !(*expected > 0.0)) return fixed(kUnknown, 0);
  return at_most(std::sqrt(std::max(*nees, 0.0) / *expected), 100.0, 1);
}

const VehicleView* least_certain(const RunData& run) {
  const VehicleView* worst = nullptr;
  for (const VehicleView& v : run.vehicles) {
    if (!v.numbers.sigma_max_m) continue;
    if (worst == nullptr || *v.numbers.sigma_max_m > *worst->numbers.sigma_max_m) worst = &v;
  }
  return worst;
}

std::string_view state_class(CheckState state) {
  switch (state) {
    case CheckState::kGood:
      return "good";
    case CheckState::kLook:
      return "look";
    case CheckState::kBad:
      return "bad";
    case CheckState::kNotChecked:
      break;
  }
  return "none";
}

std::string_view state_word(CheckState state) {
  switch (state) {
    case CheckState::kGood:
      return "\xE2\x9C\x93 good";
    case CheckState::kLook:
      return "! look";
    case CheckState::kBad:
      return "\xE2\x9C\x97 bad";
    case CheckState::kNotChecked:
      break;
  }
  return "\xE2\x80\x93 not checked";
}

Number largest_error(const RunData& run) { return measured(run, "fleet.trajectory.ape_m.max"); }

std::string ranges_unused(const RunData& run) {
  if (run.ranges.total.value_or(0.0) > 0.0) return {};
  for (const Warning& w : run.warnings) {
    if (w.id.starts_with("ranges.")) return escaped(w.text);
  }
  return {};
}

Number truth_error(const RunData& run) { return measured(run, "fleet.trajectory.ape_m.rmse"); }

std::vector<Check> checks_of(const RunData& run) {
  return {run_check(run),        input_check(run), divergence_check(run),
          degenerate_check(run), map_check(run),   frame_check(run),
          range_check(run),      loop_check(run),  truth_check(run)};
}

std::string largest_uncertainty(const RunData& run) {
  for (const std::string& uncertainty :
       {uncertainty_of_status(run), uncertainty_of_vehicles(run)}) {
    if (!uncertainty.empty()) return uncertainty;
  }
  if (const Check map = map_check(run); map.state == CheckState::kBad) {
    return "the map contradicts its own scans: " + map.found + '.';
  }
  if (const std::string fault = covariance_fault(run); !fault.empty()) {
    return "stated and measured errors disagree: " + fault + '.';
  }
  if (!run.warnings.empty()) return escaped(run.warnings.front().text);
  if (const Check input = input_check(run); input.state == CheckState::kLook) {
    return "the input has gaps: " + input.found + '.';
  }
  if (!run.evaluated()) {
    const VehicleView* worst = least_certain(run);
    return (worst == nullptr
                ? std::string()
                : fmt::format("the position of {}, {} (1 sigma). ", escaped(worst->name),
                              metres(worst->numbers.sigma_max_m))) +
           "Nothing here was measured against a ground truth: errors are those that the "
           "covariances state.";
  }
  if (const VehicleView* worst = least_certain(run)) {
    return fmt::format("the position of {}, {} (1 sigma); ground truth agrees with it.",
                       escaped(worst->name), metres(worst->numbers.sigma_max_m));
  }
  return "none that this run can show; the ground truth has errors of its own.";
}

}  // namespace rali::report
