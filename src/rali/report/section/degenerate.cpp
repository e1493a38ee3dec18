#include "rali/report/section/degenerate.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "rali/report/internal/html.hpp"
#include "rali/report/section/degenerate_words.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

constexpr std::size_t kSpansMax = 30;
constexpr double kDegPerRad = 57.29577951308232, kUpright = 0.8;

/// Heading of an axis, -90 to 90 degrees: an axis has no sign.
double heading_deg(const geometry::Vec3& axis) {
  double heading = std::atan2(axis.y(), axis.x()) * kDegPerRad;
  if (heading > 90.0) heading -= 180.0;
  if (heading <= -90.0) heading += 180.0;
  return heading;
}

std::string axis_cell(const DegenerateSpan& b) {
  if (!(b.axis.norm() > 0.5)) return "not known";
  if (std::abs(b.axis.z()) > kUpright) return std::string(axis_words(b));
  return fmt::format("{}, {}&deg; from x of the map", axis_words(b), fixed(heading_deg(b.axis), 0));
}

/// "ranges to v1, 97 %; nothing, 3 %"
std::string held_cell(const DegenerateSpan& b) {
  std::string text;
  const auto add = [&](HeldBy by, const std::string& words) {
    const double fraction = b.held_fraction[static_cast<std::size_t>(by)];
    if (fraction <= 0.0) return;
    text += fmt::format("{}{}, {}", text.empty() ? "" : "; ", words, percent(fraction));
  };
  add(HeldBy::kNothing, "<b>nothing</b>");
  add(HeldBy::kRange, b.held_by.empty() ? "ranges" : "ranges to " + escaped(b.held_by));
  add(HeldBy::kImu, "inertia alone");
  add(HeldBy::kLidar, "LiDAR");
  return text;
}

std::string off_cell(const DegenerateSpan& b) {
  if (!std::isfinite(b.off_max_m)) return "not known";
  return "<b>&plusmn; " + metres(b.off_max_m) + "</b>";
}

/// Periods of all vehicles, the worst first.
struct Entry {
  const VehicleView* v;
  const DegenerateSpan* b;
};

std::vector<Entry> entries_of(const RunData& run) {
  std::vector<Entry> list;
  for (const VehicleView& v : run.vehicles) {
    for (const DegenerateSpan& b : v.degenerate) list.push_back({&v, &b});
  }
  const auto weight = [](const Entry& e) {
    return std::isfinite(e.b->off_max_m) ? e.b->off_max_m : -1.0;
  };
  std::stable_sort(list.begin(), list.end(),
                   [&](const Entry& a, const Entry& b) { return weight(a) > weight(b); });
  return list;
}

std::string table_html(const std::vector<Entry>& entries) {
  Table table({"vehicle", "from", "to", "distance", "degenerate axis", "constrained by",
               "expected error along it (1 sigma)"});
  for (std::size_t i = 0; i < std::min(entries.size(), kSpansMax); ++i) {
    const DegenerateSpan& b = *entries[i].b;
    table.row({escaped(entries[i].v->name), fixed(b.start_s, 1) + " s", fixed(b.end_s, 1) + " s",
               metres(b.path_m), axis_cell(b), held_cell(b), off_cell(b)});
  }
  std::string html = "<div class=\"wide\">" + table.html() + "</div>";
  if (entries.size() > kSpansMax) {
    html += fmt::format("<p class=\"note\">The {} worst of {}; all are in degeneracy/.</p>\n",
                        kSpansMax, entries.size());
  }
  return html;
}

/// Length or duration and its fraction of the degenerate part.
std::string part_cell(const VehicleView& v, const PathFraction& part) {
  const PathFraction& degenerate = v.degenerate_path.degenerate;
  const double all = stood(v) ? degenerate.s : degenerate.m, some = stood(v) ? part.s : part.m;
  if (!(all > 0.0)) return fixed(kUnknown, 0);
  return amount_words(v, part) + " (" + percent(some / all) + ")";
}

std::string peak_cell(const OffPeak& peak) {
  if (!std::isfinite(peak.off_m)) return "not known";
  return fmt::format("<b>&plusmn; {}</b> at {} s", metres(peak.off_m), fixed(peak.t_s, 0));
}

std::string vehicles_table(const RunData& run) {
  Table table({"vehicle", "distance", "degenerate", "constrained by ranges",
               "constrained by inertia alone", "constrained by nothing", "no range received",
               "largest expected error (1 sigma)"});
  for (const VehicleView& v : run.vehicles) {
    const DegeneratePath& path = v.degenerate_path;
    if (!path.known) {
      const std::string none = fixed(kUnknown, 0);
      table.row({escaped(v.name), "not known", none, none, none, none, none, none});
      continue;
    }
    const auto held = [&](HeldBy by) {
      return part_cell(v, path.held[static_cast<std::size_t>(by)]);
    };
    table.row({escaped(v.name), amount_words(v, path.all), amount_words(v, path.degenerate),
               held(HeldBy::kRange), held(HeldBy::kImu), held(HeldBy::kNothing),
               part_cell(v, path.without_range),
               was_degenerate(v) ? peak_cell(path.peak) : fixed(kUnknown, 0)});
  }
  return "<div class=\"wide\">" + table.lean_html() + "</div>";
}

constexpr std::string_view kHeldFigure =
    "<p class=\"legend\"><span><i data-kind=\"good\"></i> constrained by the LiDAR</span><span><i "
    "data-kind=\"by_range\"></i> by ranges</span><span><i data-kind=\"by_imu\"></i> by inertia "
    "alone</span><span><i data-kind=\"by_nothing\"></i> by nothing</span></p>\n<figure "
    "data-figure=\"held\"></figure>\n";

}  // namespace

std::string degenerate_html(const RunData& run) {
  const auto& all = run.vehicles;
  const auto known = [](const VehicleView& v) { return v.degenerate_path.known; };
  if (std::none_of(all.begin(), all.end(), known)) {
    return absent("There is no degeneracy file: where the LiDAR was degenerate is not known.");
  }
  const std::vector<Entry> entries = entries_of(run);
  if (entries.empty() && std::all_of(all.begin(), all.end(), known)) {
    return "<p>Nowhere: every scan constrained every direction.</p>\n";
  }
  std::string html = std::string(kHeldFigure) + vehicles_table(run);
  if (entries.empty()) return html;
  return html + "<h4>Degenerate stretches, the worst first</h4>" + table_html(entries) +
         "<p class=\"note\">Expected error: from the covariance of the final poses along the "
         "degenerate axis, relative to where the map starts; errors of earlier stretches are in "
         "it. Two of three errors are smaller if the covariance is right. A vehicle that stood is "
         "judged by time, others by distance. No range received: none within 2 s, used or "
         "not.</p>\n";
}

}  // namespace rali::report
