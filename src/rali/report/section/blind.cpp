#include "rali/report/section/blind.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "rali/report/internal/html.hpp"
#include "rali/report/plot/time_rows.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

constexpr std::size_t kSpansMax = 30;
constexpr double kDegPerRad = 57.29577951308232;
constexpr double kAlong = 0.85, kAcross = 0.5, kUpright = 0.8;

/// Heading of an axis, -90 to 90 degrees: an axis has no sign.
double heading_deg(const geometry::Vec3& axis) {
  double heading = std::atan2(axis.y(), axis.x()) * kDegPerRad;
  if (heading > 90.0) heading -= 180.0;
  if (heading <= -90.0) heading += 180.0;
  return heading;
}

std::string axis_cell(const BlindSpan& b) {
  if (!(b.axis.norm() > 0.5)) return "not known";
  if (std::abs(b.axis.z()) > kUpright) return axis_words(b);
  return fmt::format("{}, {}&deg; from x of the map", axis_words(b), fixed(heading_deg(b.axis), 0));
}

std::string held_cell(const BlindSpan& b) {
  if (b.held_by.empty()) return "<b>nothing</b>: no range";
  return fmt::format("ranges to {}, {} of it", escaped(b.held_by), percent(b.held_share));
}

std::string off_cell(const BlindSpan& b) {
  if (!std::isfinite(b.off_max_m)) return "not known";
  return "<b>&plusmn; " + metres(b.off_max_m) + "</b>";
}

/// Stretches of all vehicles, the worst first.
struct Entry {
  const VehicleView* v;
  const BlindSpan* b;
};

std::vector<Entry> entries_of(const RunData& run) {
  std::vector<Entry> list;
  for (const VehicleView& v : run.vehicles) {
    for (const BlindSpan& b : v.blind) list.push_back({&v, &b});
  }
  const auto weight = [](const Entry& e) {
    return std::isfinite(e.b->off_max_m) ? e.b->off_max_m : -1.0;
  };
  std::stable_sort(list.begin(), list.end(),
                   [&](const Entry& a, const Entry& b) { return weight(a) > weight(b); });
  return list;
}

std::string table_html(const std::vector<Entry>& entries) {
  Table table({"vehicle", "from", "to", "way", "blind axis", "what held it",
               "may be off along it (1 sigma)"});
  for (std::size_t i = 0; i < std::min(entries.size(), kSpansMax); ++i) {
    const BlindSpan& b = *entries[i].b;
    table.row({escaped(entries[i].v->name), fixed(b.begin_s, 1) + " s", fixed(b.end_s, 1) + " s",
               metres(b.way_m), axis_cell(b), held_cell(b), off_cell(b)});
  }
  std::string html = "<div class=\"wide\">" + table.html() + "</div>";
  if (entries.size() > kSpansMax) {
    html += fmt::format("<p class=\"note\">The {} worst of {}; all are in degeneracy/.</p>\n",
                        kSpansMax, entries.size());
  }
  return html;
}

std::vector<TimeRow> rows_of(const RunData& run) {
  std::vector<TimeRow> rows;
  for (const VehicleView& v : run.vehicles) {
    TimeRow row{v.name, {}};
    if (!v.degeneracy.empty()) {
      row.bars.push_back({v.degeneracy.front().t_s, v.degeneracy.back().t_s, "seen",
                          "every direction seen", "", 0.0, 1.0});
    }
    for (const BlindSpan& b : v.blind) {
      row.bars.push_back(
          {b.begin_s, b.end_s, "unheld",
           fmt::format("blind {}, {:.1f} to {:.1f} s", axis_words(b), b.begin_s, b.end_s), "", 0.0,
           1.0});
      if (b.held_share <= 0.0) continue;
      row.bars.push_back(
          {b.begin_s, b.end_s, "held",
           fmt::format("held by ranges to {}, {:.0f} % of it", b.held_by, 100.0 * b.held_share), "",
           0.0, 0.45});
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

constexpr std::string_view kLegend =
    "<p class=\"legend\"><span><svg width=\"24\" height=\"14\"><rect class=\"seen\" width=\"24\" "
    "height=\"14\"/></svg> every direction seen</span><span><svg width=\"24\" height=\"14\"><rect "
    "class=\"unheld\" width=\"24\" height=\"14\"/></svg> blind along one axis</span><span><svg "
    "width=\"24\" height=\"14\"><rect class=\"unheld\" width=\"24\" height=\"14\"/><rect "
    "class=\"held\" y=\"7.5\" width=\"24\" height=\"6.5\"/></svg> blind, but held by ranges</span>"
    "</p>\n";

}  // namespace

std::string axis_words(const BlindSpan& span) {
  if (!(span.axis.norm() > 0.5)) return "along an axis that is not known";
  if (std::abs(span.axis.z()) > kUpright) return "up and down";
  if (span.along_way >= kAlong) return "in the direction it drove";
  if (span.along_way <= kAcross) return "across the direction it drove";
  return std::isfinite(span.along_way) ? "aslant to the direction it drove" : "along a level axis";
}

const BlindSpan* worst_blind(const VehicleView& v) {
  const BlindSpan* worst = nullptr;
  for (const BlindSpan& b : v.blind) {
    if (worst == nullptr || b.off_max_m > worst->off_max_m ||
        (std::isfinite(b.off_max_m) && !std::isfinite(worst->off_max_m))) {
      worst = &b;
    }
  }
  return worst;
}

double unheld_share(const VehicleNumbers& n) {
  return n.blind_share.value_or(0.0) * (1.0 - n.blind_held_share.value_or(0.0));
}

std::string blind_html(const RunData& run) {
  const bool known = std::any_of(run.vehicles.begin(), run.vehicles.end(),
                                 [](const VehicleView& v) { return !v.degeneracy.empty(); });
  if (!known) return absent("There is no degeneracy file: where it was blind is not known.");
  const std::vector<Entry> entries = entries_of(run);
  if (entries.empty()) {
    return "<p>Blind nowhere: in every sweep the walls held every direction.</p>\n";
  }
  return std::string(kLegend) + "<figure>" +
         svg_of(rows_of(run), last_time_s(run), "when the vehicles were blind") + "</figure>\n" +
         table_html(entries) +
         "<p class=\"note\">May be off: the covariance of the final poses along the blind axis, "
         "seen from where the map begins; errors of earlier stretches are in it. Two of three "
         "times the true error is smaller, if the program knows itself well.</p>\n";
}

}  // namespace rali::report
