#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "rali/base/counted.hpp"
#include "rali/report/internal/html.hpp"
#include "rali/report/section/checks.hpp"
#include "rali/report/section/degenerate_words.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

double path_sum_m(const RunData& run) {
  double sum_m = 0.0;
  for (const VehicleView& v : run.vehicles) sum_m += v.numbers.path_m.value_or(0.0);
  return sum_m;
}

std::string what_sentence(const RunData& run) {
  std::string text = rali::counted(run.vehicles.size(), "vehicle");
  text +=
      run.metrics_known ? fmt::format(" drove {}", metres(path_sum_m(run))) : " left a trajectory";
  if (run.duration_s) text += fmt::format(" in {} s", fixed(run.duration_s, 0));
  if (run.map_points.value_or(0.0) > 0.0) {
    text += fmt::format("; the map holds {} points", counted(run.map_points));
  } else {
    text += "; there is no map";
  }
  return text + '.';
}

std::string expected_words(const VehicleView& v) {
  const auto peak = std::max_element(
      v.sigmas.begin(), v.sigmas.end(),
      [](const SigmaPoint& a, const SigmaPoint& b) { return a.sigma_m < b.sigma_m; });
  const std::string when =
      peak == v.sigmas.end() ? "" : fmt::format(" at {} s", fixed(peak->t_s, 0));
  return fmt::format("{} ({}{}; 1 sigma: two of three errors are smaller)",
                     metres(v.numbers.sigma_max_m), escaped(v.name), when);
}

std::string error_sentence(const RunData& run) {
  const VehicleView* worst = least_certain(run);
  if (const Number ape = truth_error(run)) {
    std::string text =
        fmt::format("Against ground truth the positions are off by {} (rmse)", metres(ape));
    if (const Number maximum = largest_error(run))
      text += fmt::format(", at most {}", metres(maximum));
    if (worst == nullptr) return text + '.';
    return text + "; the expected error is at most " + expected_words(*worst) + '.';
  }
  if (worst == nullptr) return "How large the position errors are is not known.";
  return "The position error is expected to be at most " + expected_words(*worst) + '.';
}

/// Ordering: first by the unconstrained distance, then by the larger expected error.
bool is_worse(const VehicleView* a, const VehicleView* b) {
  const auto nothing_m = [](const VehicleView* v) {
    return v->degenerate_path.held[static_cast<std::size_t>(HeldBy::kNothing)].m;
  };
  if (nothing_m(a) != nothing_m(b)) return nothing_m(a) > nothing_m(b);
  const double off_a = a->degenerate_path.peak.off_m, off_b = b->degenerate_path.peak.off_m;
  return off_a > off_b || (std::isfinite(off_a) && !std::isfinite(off_b));
}

/// Where the LiDAR was degenerate: the worst vehicle in words, the others as a number.
std::string degenerate_sentence(const RunData& run) {
  std::vector<const VehicleView*> degenerate;
  std::vector<std::string> unknown;
  for (const VehicleView& v : run.vehicles) {
    if (!blindness_known(v)) unknown.push_back(v.name);
    if (was_degenerate(v)) degenerate.push_back(&v);
  }
  if (unknown.size() == run.vehicles.size())
    return "Whether the LiDAR was degenerate is not known.";
  if (degenerate.empty() && unknown.empty()) {
    return "The LiDAR constrained every direction on the whole path.";
  }
  std::string text;
  if (!degenerate.empty()) {
    text =
        degenerate_sentence_of(**std::min_element(degenerate.begin(), degenerate.end(), is_worse));
  }
  if (degenerate.size() > 1) {
    text += fmt::format("; {} of {} vehicles were degenerate at times", degenerate.size(),
                        run.vehicles.size());
  }
  if (!unknown.empty()) {
    text += fmt::format("{}whether {} {} degenerate is not known", text.empty() ? "" : "; ",
                        names_text(unknown), unknown.size() == 1 ? "was" : "were");
  }
  return text + '.';
}

std::string tile(std::string_view value, std::string_view label) {
  return fmt::format("<div class=\"tile\"><b>{}</b><span>{}</span></div>", value, label);
}

std::string tiles(const RunData& run) {
  std::string out = "<div class=\"tiles\">";
  out += tile(metres(path_sum_m(run)), run.vehicles.size() > 1 ? "path, all vehicles" : "path");
  if (run.duration_s) out += tile(fixed(run.duration_s, 0) + " s", "of data");
  out += tile(counted(run.map_points), "map points");
  if (const VehicleView* worst = least_certain(run)) {
    out += tile(metres(worst->numbers.sigma_max_m), "largest expected error, 1 sigma");
  }
  if (const Number ape = truth_error(run))
    out += tile(metres(ape), "error against ground truth (rmse)");
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

constexpr std::string_view kDegenerateNote =
    "<p class=\"note\">Degenerate: along one direction the LiDAR does not constrain the position, "
    "as along a smooth tunnel. There ranges or inertia must, or the map may be too long or too "
    "short.</p>\n";

bool any_degenerate(const RunData& run) {
  return std::any_of(run.vehicles.begin(), run.vehicles.end(), was_degenerate);
}

}  // namespace

Section verdict_section(const RunData& run) {
  std::string html = fmt::format(
      "<div class=\"verdict\"><p class=\"lead\">{} {} {}</p>\n<p class=\"doubt\"><b>Largest "
      "uncertainty:</b> {}</p>{}</div>\n",
      what_sentence(run), error_sentence(run), degenerate_sentence(run), largest_uncertainty(run),
      any_degenerate(run) ? kDegenerateNote : "");
  html += tiles(run) + checks_html(run);
  return {"verdict", "Verdict", std::move(html)};
}

}  // namespace rali::report
