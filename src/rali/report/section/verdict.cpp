#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "rali/base/counted.hpp"
#include "rali/report/internal/html.hpp"
#include "rali/report/section/blind_words.hpp"
#include "rali/report/section/checks.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

double path_sum_m(const RunData& run) {
  double sum_m = 0.0;
  for (const VehicleView& v : run.vehicles) sum_m += v.numbers.path_m.value_or(0.0);
  return sum_m;
}

/// Way of all vehicles in truth, where nearly all of it was judged.
Number true_path_m(const RunData& run) {
  constexpr double kNearlyAll = 0.98;
  double sum_m = 0.0;
  for (const VehicleView& v : run.vehicles) {
    const std::string track = "vehicles." + v.name + ".trajectory.";
    const Number way_m = measured(run, track + "distance_m");
    if (!way_m || measured(run, track + "time_fraction").value_or(0.0) < kNearlyAll) return {};
    sum_m += *way_m;
  }
  return run.vehicles.empty() ? Number() : Number(sum_m);
}

std::string what_sentence(const RunData& run) {
  std::string text = rali::counted(run.vehicles.size(), "vehicle");
  text +=
      run.metrics_known ? fmt::format(" drove {}", metres(path_sum_m(run))) : " left a trajectory";
  if (const Number truth_m = true_path_m(run); truth_m && run.metrics_known) {
    text += fmt::format(" (in truth {})", metres(truth_m));
  }
  if (run.duration_s) text += fmt::format(" in {} s", fixed(run.duration_s, 0));
  if (run.map_points.value_or(0.0) > 0.0) {
    text += fmt::format("; the map holds {} points", counted(run.map_points));
  } else {
    text += "; there is no map";
  }
  return text + '.';
}

/// The vehicle with the largest expected error and when that was.
const VehicleView* worst_vehicle(const RunData& run) {
  const VehicleView* worst = nullptr;
  for (const VehicleView& v : run.vehicles) {
    if (!v.numbers.sigma_max_m) continue;
    if (worst == nullptr || *v.numbers.sigma_max_m > *worst->numbers.sigma_max_m) worst = &v;
  }
  return worst;
}

std::string error_sentence(const RunData& run) {
  const VehicleView* worst = worst_vehicle(run);
  std::string text;
  if (const Number ape = truth_error(run)) {
    text = fmt::format("Against the truth the positions are off by {} (APE rmse)", metres(ape));
    if (const Number most = largest_error(run)) text += fmt::format(", at most {}", metres(most));
    if (worst != nullptr) {
      text += fmt::format("; the program expected {} at worst (1 sigma)",
                          metres(worst->numbers.sigma_max_m));
    }
    return text + '.';
  }
  if (worst == nullptr) return "How far off the positions may be is not known.";
  text = fmt::format("Expected position error (1 sigma): at worst {}",
                     metres(worst->numbers.sigma_max_m));
  const auto peak = std::max_element(
      worst->sigmas.begin(), worst->sigmas.end(),
      [](const SigmaPoint& a, const SigmaPoint& b) { return a.sigma_m < b.sigma_m; });
  text += " (" + escaped(worst->name);
  if (peak != worst->sigmas.end()) text += fmt::format(" at {} s", fixed(peak->t_s, 0));
  text += ")";
  if (run.vehicles.size() == 1) {
    text += fmt::format(", median {}", metres(worst->numbers.sigma_median_m));
  }
  return text + '.';
}

constexpr std::size_t kNamesMax = 3;

/// Worse: more of the way held by nothing, then the larger expected error.
bool is_worse(const VehicleView* a, const VehicleView* b) {
  const auto nothing_m = [](const VehicleView* v) {
    return v->blind_way.held[static_cast<std::size_t>(HeldBy::kNothing)].m;
  };
  if (nothing_m(a) != nothing_m(b)) return nothing_m(a) > nothing_m(b);
  const double off_a = a->blind_way.peak.off_m, off_b = b->blind_way.peak.off_m;
  return off_a > off_b || (std::isfinite(off_a) && !std::isfinite(off_b));
}

/// Where it was blind, what held it there and how far off it may be: a part per vehicle.
std::string blind_sentence(const RunData& run) {
  std::vector<const VehicleView*> blind;
  std::vector<std::string> unknown;
  for (const VehicleView& v : run.vehicles) {
    if (!blindness_known(v)) unknown.push_back(v.name);
    if (was_blind(v)) blind.push_back(&v);
  }
  if (unknown.size() == run.vehicles.size()) {
    return "Whether the LiDAR was blind anywhere is not known.";
  }
  std::string text;
  if (blind.empty() && unknown.empty()) {
    return "The LiDAR saw enough in every direction, on the whole way.";
  }
  std::stable_sort(blind.begin(), blind.end(), is_worse);
  for (std::size_t i = 0; i < std::min(blind.size(), kNamesMax); ++i) {
    text += (text.empty() ? "" : " ") + blind_sentence_of(*blind[i]) + '.';
  }
  if (blind.size() > kNamesMax) {
    text += fmt::format(" In all {} of {} vehicles were blind at times.", blind.size(),
                        run.vehicles.size());
  }
  if (!unknown.empty()) {
    text += fmt::format("{}Whether {} {} blind is not known.", text.empty() ? "" : " ",
                        names_text(unknown), unknown.size() == 1 ? "was" : "were");
  }
  return text;
}

std::string tile(std::string_view value, std::string_view label) {
  return fmt::format("<div class=\"tile\"><b>{}</b><span>{}</span></div>", value, label);
}

std::string tiles(const RunData& run) {
  std::string out = "<div class=\"tiles\">";
  out += tile(metres(path_sum_m(run)), run.vehicles.size() > 1 ? "path, all vehicles" : "path");
  if (run.duration_s) out += tile(fixed(run.duration_s, 0) + " s", "of data");
  out += tile(counted(run.map_points), "map points");
  if (const VehicleView* worst = worst_vehicle(run)) {
    out += tile(metres(worst->numbers.sigma_max_m), "expected error at worst, 1 sigma");
  }
  if (const Number ape = truth_error(run))
    out += tile(metres(ape), "error against truth (APE rmse)");
  Number thickness = run.map_thickness_m;
  if (thickness && *thickness > 0.0)
    out += tile(metres(thickness), "thickness of walls in the map, median");
  return out + "</div>\n";
}

std::string checks_html(const RunData& run) {
  Table table({"", "checked", "found"});
  for (const Check& check : checks_of(run)) {
    table.row({fmt::format("<span class=\"state {}\">{}</span>", state_class(check.state),
                           state_word(check.state)),
               check.what, check.found});
  }
  return "<div class=\"checks\">" + table.html(true) + "</div>";
}

}  // namespace

Section verdict_section(const RunData& run) {
  std::string html = fmt::format(
      "<div class=\"verdict\"><p class=\"lead\">{} {} {}</p>\n<p class=\"doubt\"><b>Largest "
      "doubt:</b> "
      "{}</p></div>\n",
      what_sentence(run), error_sentence(run), blind_sentence(run), largest_doubt(run));
  html += tiles(run) + checks_html(run);
  return {"verdict", "Verdict", std::move(html)};
}

}  // namespace rali::report
