#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "rali/report/internal/html.hpp"
#include "rali/report/plot/svg_plot.hpp"
#include "rali/report/section/checks.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

constexpr std::size_t kPlotsMax = 12;
/// Light and dark: they differ on grey paper too.
constexpr Rgb kUsedColour = {125, 172, 214}, kRejectedColour = {150, 52, 0};

std::string reason_words(const std::string& reason) {
  static const std::map<std::string, std::string> kWords = {
      {"nlos", "no line of sight"},
      {"outlier", "outlier"},
      {"out_of_limits", "out of limits"},
      {"no_pose", "no pose at that time"},
      {"duplicate", "measured twice"},
      {"unknown_id", "unknown radio"},
      {"late", "too late"},
      {"blocked_by_gate", "stopped by the gate"},
      {"used", "used"}};
  const auto found = kWords.find(reason);
  return found == kWords.end() ? escaped(reason) : found->second;
}

std::string pair_of(const RangeRow& row) {
  return row.from < row.to ? row.from + "-" + row.to : row.to + "-" + row.from;
}

std::string reasons_table(const RunData& run) {
  Table table({"what became of them", "ranges", "share"});
  const double total = run.ranges.total.value_or(0.0);
  const auto add = [&](const std::string& words, double n) {
    table.row({words, counted(n), total > 0.0 ? percent(n / total) : fixed(kUnknown, 0)});
  };
  add("used", run.ranges.used.value_or(0.0));
  for (const auto& [reason, n] : run.ranges.rejected) add("rejected: " + reason_words(reason), n);
  add("<b>all</b>", total);
  return table.html();
}

std::string pairs_table(const RunData& run) {
  Table table({"pair", "bias", "&plusmn; (1 sigma)", "spread of residuals", "latency"});
  for (const RangePair& p : run.ranges.pairs) {
    table.row({escaped(p.name), metres(p.bias_m), metres(p.bias_sigma_m), metres(p.residual_std_m),
               p.latency_s ? fixed(1e3 * *p.latency_s, 0) + " ms" : fixed(kUnknown, 0)});
  }
  return table.empty() ? "" : table.html();
}

Plot residual_plot(const RunData& run, const std::string& pair) {
  Plot plot;
  plot.title = pair;
  plot.y_label = "residual [m]";
  plot.y_unit = "m";
  plot.width = 440.0;
  plot.height = 140.0;
  plot.x_min = 0.0;
  plot.x_max = last_time_s(run);
  Series used{"used", {}, {}, {kUsedColour, ""}, true, 2.2};
  Series rejected{"rejected", {}, {}, {kRejectedColour, ""}, true, 3.6};
  std::vector<double> sizes;
  for (const RangeRow& row : run.range_rows) {
    if (pair_of(row) != pair || !std::isfinite(row.residual_m)) continue;
    Series& s = row.used ? used : rejected;
    s.x.push_back(row.t_s);
    s.y.push_back(row.residual_m);
    sizes.push_back(std::abs(row.residual_m));
  }
  // A few wild ranges must not flatten the rest: they stand at the border.
  if (!sizes.empty()) {
    const auto at = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() * 97 / 100);
    std::nth_element(sizes.begin(), at, sizes.end());
    plot.y_max = std::max(1.3 * *at, 0.05);
    plot.y_min = -*plot.y_max;
  }
  plot.series = {std::move(rejected), std::move(used)};
  return plot;
}

std::vector<std::string> pairs_of_rows(const RunData& run) {
  std::vector<std::string> pairs;
  for (const RangeRow& row : run.range_rows) pairs.push_back(pair_of(row));
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

}  // namespace

Section ranges_section(const RunData& run) {
  Section section{"ranges", "Ranges", ""};
  if (run.ranges.total.value_or(0.0) <= 0.0 && run.range_rows.empty()) {
    const std::string why = ranges_unused(run);
    section.html = absent("No range was used: nothing but LiDAR and inertia holds the map." +
                          (why.empty() ? "" : " " + why + "."));
    return section;
  }
  section.html = "<div class=\"plots\"><div>" + reasons_table(run) + "</div><div>" +
                 pairs_table(run) + "</div></div>\n";
  if (run.range_rows.empty()) {
    section.html += absent("There is no ranges.csv: single residuals are not known.");
    return section;
  }
  section.html +=
      "<p class=\"note\">Residual: measured less predicted range, after the bias. "
      "Large dark dots were rejected; dots at the border lie farther out.</p>\n"
      "<div class=\"plots\">";
  const std::vector<std::string> pairs = pairs_of_rows(run);
  for (std::size_t i = 0; i < std::min(pairs.size(), kPlotsMax); ++i) {
    const std::string svg = svg_of(residual_plot(run, pairs[i]));
    if (!svg.empty()) section.html += "<figure>" + svg + "</figure>";
  }
  section.html += "</div>\n";
  if (pairs.size() > kPlotsMax) {
    section.html += fmt::format(
        "<p class=\"note\">{} of {} pairs are drawn; all are in ranges.csv."
        "</p>\n",
        kPlotsMax, pairs.size());
  }
  return section;
}

}  // namespace rali::report
