#include <fmt/format.h>

#include "rali/report/internal/html.hpp"
#include "rali/report/section/degenerate_words.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

/// "0.0310 / 0.0300": as measured while driving and as stated in the data sheet.
std::string noise_cell(const Number& measured, const Number& stated, int decimals) {
  if (!measured) return fixed(kUnknown, 0);
  return fmt::format("{} / {}", fixed(measured, decimals), fixed(stated, decimals));
}

std::string numbers_table(const RunData& run) {
  Table table({"vehicle", "path", "scans", "scans dropped", "keyframes", "degenerate",
               "degenerate part constrained by ranges", "expected error, median",
               "expected error, largest", "diverged", "added to all stamps", "LiDAR clock off by",
               "accel. scale", "accel. noise / stated [m/s2/rtHz]",
               "gyro noise / stated [rad/s/rtHz]"});
  for (const VehicleView& v : run.vehicles) {
    const VehicleNumbers& n = v.numbers;
    table.row({escaped(v.name), metres(n.path_m), counted(n.scans), counted(n.scans_dropped),
               counted(n.keyframes), percent(n.degenerate_fraction),
               n.degenerate_fraction.value_or(0.0) > 0.0 ? percent(n.degenerate_held_fraction)
                                                         : fixed(kUnknown, 0),
               metres(n.sigma_median_m), metres(n.sigma_max_m), fixed(n.diverged_s, 1) + " s",
               fixed(n.clock_offset_s, 4) + (n.clock_offset_s ? " s" : ""),
               n.time_offset_s ? fixed(1e3 * *n.time_offset_s, 1) + " ms" : fixed(kUnknown, 0),
               fixed(n.accel_scale, 4), noise_cell(n.accel_noise, n.accel_noise_stated, 4),
               noise_cell(n.gyro_noise, n.gyro_noise_stated, 5)});
  }
  return "<div class=\"wide\">" + table.lean_html() + "</div>";
}

constexpr std::string_view kNote =
    "<p class=\"note\">Expected error: 1 sigma of the position in space (root of the trace of its "
    "covariance), relative to where the map starts; two of three errors are smaller. Degree of "
    "degeneracy: ratio of the two smaller eigenvalues of translation; 1 where all directions are "
    "observed alike, large where one is not. Headings count from x of the map.</p>\n";

/// Keys of the rows of states, and the axis of the plots.
constexpr std::string_view kStateKeys =
    "<p class=\"legend\"><span><i data-kind=\"good\"></i> LiDAR observes all directions</span>"
    "<span><i data-kind=\"partial\"></i> one direction weak</span><span><i "
    "data-kind=\"degenerate\"></i> degenerate along one axis</span><span><i "
    "data-kind=\"by_range\"></i> constrained by ranges</span><span><i data-kind=\"by_imu\"></i> by "
    "inertia alone</span><span><i data-kind=\"by_nothing\"></i> by nothing</span></p>\n<p "
    "class=\"tools\"><label>plots over <select id=\"over\"><option value=\"time\">time</option>"
    "<option value=\"distance\">distance travelled</option></select></label> <span "
    "class=\"note\">drag to zoom all plots of a vehicle, double click for all; hatched: "
    "degenerate</span></p>\n";

/// The plots of a vehicle at standstill would be lines of zeros: one sentence replaces them.
std::string stood_words(const VehicleView& v) {
  std::string text = fmt::format("It stood still for all {} s of its trajectory",
                                 fixed(v.path.back().t_s - v.path.front().t_s, 0));
  if (v.numbers.sigma_max_m) {
    text += fmt::format("; its position is expected to be within {} (1 sigma)",
                        metres(v.numbers.sigma_max_m));
  }
  return text + (was_degenerate(v) ? ". " + degenerate_sentence_of(v) + "." : ".");
}

}  // namespace

Section vehicles_section(const RunData& run) {
  Section section{"vehicles", "Vehicles", ""};
  if (run.vehicles.empty()) {
    section.html = absent("No vehicle left a pose.");
    return section;
  }
  section.html = numbers_table(run) + std::string(kNote);
  bool moved = false;
  for (const VehicleView& v : run.vehicles) moved |= !stood(v) && !v.path.empty();
  if (moved) section.html += std::string(kStateKeys);
  for (std::size_t i = 0; i < run.vehicles.size(); ++i) {
    const VehicleView& v = run.vehicles[i];
    section.html += fmt::format("<h3>{}</h3>\n", escaped(v.name));
    if (v.path.empty()) {
      section.html += absent("It has no trajectory.");
    } else if (stood(v)) {
      section.html += "<p>" + stood_words(v) + "</p>\n";
      continue;
    }
    section.html += fmt::format("<div data-figure=\"vehicle\" data-vehicle=\"{}\"></div>\n", i);
  }
  return section;
}

}  // namespace rali::report
