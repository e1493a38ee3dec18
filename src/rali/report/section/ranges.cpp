#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "rali/report/data/page_data.hpp"
#include "rali/report/internal/html.hpp"
#include "rali/report/section/checks.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {
namespace {

constexpr std::size_t kPairsMax = 40;

/// Text for a reason of metrics.json; the reason itself if unknown.
std::string reason_words(const std::string& reason) {
  const RangeOutcome outcome = outcome_of(reason, false);
  return outcome == RangeOutcome::kOther ? escaped(reason) : std::string(outcome_words(outcome));
}

std::string number(std::size_t n) { return counted(static_cast<double>(n)); }

/// metrics.json counts the ranges passed to the map; without it ranges.csv is counted.
std::string reasons_table(const RunData& run) {
  Table table({"what became of them", "ranges", "fraction"});
  const bool of_metrics = run.ranges.total.has_value();
  const RangeTable& rows = run.range_table;
  const double total = of_metrics ? *run.ranges.total : static_cast<double>(rows.rows);
  const auto add = [&](const std::string& words, double n) {
    table.row({words, counted(n), total > 0.0 ? percent(n / total) : fixed(kUnknown, 0)});
  };
  if (of_metrics) {
    add("used", run.ranges.used.value_or(0.0));
    for (const auto& [reason, n] : run.ranges.rejected) add("rejected: " + reason_words(reason), n);
  } else {
    for (std::size_t i = 0; i < kRangeOutcomeCount; ++i) {
      const std::string words(outcome_words(static_cast<RangeOutcome>(i)));
      if (i == 0 || rows.count[i] > 0) {
        add(i == 0 ? words : "rejected: " + words, static_cast<double>(rows.count[i]));
      }
    }
  }
  add("<b>all</b>", total);
  return table.html();
}

/// The pair of metrics.json, in either order of its ends.
const RangePair* numbers_of(const RunData& run, const PairRanges& pair) {
  for (const RangePair& p : run.ranges.pairs) {
    if (p.name == pair.a + "-" + pair.b || p.name == pair.b + "-" + pair.a) return &p;
  }
  return nullptr;
}

std::string bias_cell(Number bias_m, Number sigma_m) {
  if (!bias_m || !std::isfinite(*bias_m)) return "not known";
  if (!sigma_m) return fixed(*bias_m, 3) + " m, &plusmn; not known";
  return fmt::format("{} &plusmn; {} m", fixed(*bias_m, 3), fixed(*sigma_m, 3));
}

std::string known_metres(const Number& value) {
  return value && std::isfinite(*value) ? fixed(*value, 3) + " m" : std::string("not known");
}

std::string latency_cell(const RangePair* p) {
  if (p == nullptr || !p->latency_s) return "not known";
  const std::string value = fixed(1e3 * *p->latency_s, 0);
  if (!p->latency_sigma_s) return value + " ms, as set";
  return fmt::format("{} &plusmn; {} ms", value, fixed(1e3 * *p->latency_sigma_s, 0));
}

std::vector<std::string> cells_of(const RunData& run, const PairRanges& pair,
                                  const std::vector<std::size_t>& fates) {
  const RangePair* p = numbers_of(run, pair);
  std::vector<std::string> cells = {escaped(pair.a) + "-" + escaped(pair.b), number(pair.total()),
                                    number(pair.used())};
  for (const std::size_t outcome : fates) cells.push_back(number(pair.count[outcome]));
  cells.push_back(bias_cell(p != nullptr && p->bias_m ? p->bias_m : Number(pair.bias_m),
                            p != nullptr ? p->bias_sigma_m : Number()));
  cells.push_back(known_metres(p != nullptr && p->residual_std_m ? p->residual_std_m
                                                                 : Number(pair.residual_std_m)));
  cells.push_back(latency_cell(p));
  return cells;
}

/// Pairs of metrics.json, used without ranges.csv.
std::string pairs_of_metrics(const RunData& run) {
  Table table({"pair", "bias (1 sigma)", "spread of residuals", "latency"});
  for (const RangePair& p : run.ranges.pairs) {
    if (table.size() >= kPairsMax) break;
    table.row({escaped(p.name), bias_cell(p.bias_m, p.bias_sigma_m), known_metres(p.residual_std_m),
               latency_cell(&p)});
  }
  return table.empty() ? "" : "<div class=\"wide\">" + table.html() + "</div>\n";
}

std::string pairs_table(const RunData& run) {
  const std::vector<PairRanges>& pairs = run.range_table.pairs;
  if (pairs.empty()) return pairs_of_metrics(run);
  std::vector<std::size_t> fates;
  for (std::size_t i = 1; i < kRangeOutcomeCount; ++i) {
    const auto has = [i](const PairRanges& pair) { return pair.count[i] > 0; };
    if (std::any_of(pairs.begin(), pairs.end(), has)) fates.push_back(i);
  }
  std::vector<std::string> head = {"pair", "ranges", "used"};
  for (const std::size_t i : fates) {
    head.emplace_back(outcome_words(static_cast<RangeOutcome>(i)));
  }
  for (const char* name : {"bias (1 sigma)", "spread of residuals used", "latency"}) {
    head.emplace_back(name);
  }
  Table table(std::move(head));
  for (std::size_t i = 0; i < std::min(pairs.size(), kPairsMax); ++i) {
    table.row(cells_of(run, pairs[i], fates));
  }
  return "<div class=\"wide\">" + table.lean_html() + "</div>\n";
}

std::string quoted_list(const std::vector<std::string>& names) {
  std::string out;
  for (const std::string& name : names) {
    out += (out.empty() ? "" : ", ") + (name.empty() ? std::string("no name") : escaped(name));
  }
  return out;
}

/// Rows that belong to no pair of the table.
std::string strangers_note(const RunData& run) {
  const RangeTable& table = run.range_table;
  std::string html;
  if (table.strangers > 0) {
    html += fmt::format(
        "<p class=\"note\">{} ranges are to or from what is no vehicle of this run ({}{}).</p>\n",
        number(table.strangers), quoted_list(table.stranger_names),
        table.stranger_names.size() >= 5 ? ", .." : "");
  }
  if (!table.other_reasons.empty()) {
    html += fmt::format(
        "<p class=\"note\">Reasons that this version does not know, or that contradict the column "
        "used: {}.</p>\n",
        quoted_list(table.other_reasons));
  }
  return html;
}

/// "no range of v1-v2 has a residual: 389 no pose at that time"
std::string without_residual(const PairRanges& pair) {
  std::string found;
  for (std::size_t i = 0; i < kRangeOutcomeCount; ++i) {
    if (pair.count[i] == 0) continue;
    found += fmt::format("{}{} {}", found.empty() ? "" : ", ", number(pair.count[i]),
                         outcome_words(static_cast<RangeOutcome>(i)));
  }
  return fmt::format("<p class=\"note\">{} - {}: no range has a residual ({}).</p>\n",
                     escaped(pair.a), escaped(pair.b), found);
}

bool has_residual(const PairRanges& pair) {
  return std::any_of(pair.dots.begin(), pair.dots.end(), [](const std::vector<RangeDot>& dots) {
    return std::any_of(dots.begin(), dots.end(),
                       [](const RangeDot& dot) { return std::isfinite(dot.residual_m); });
  });
}

std::string residual_plots(const RunData& run) {
  const std::vector<PairRanges>& pairs = run.range_table.pairs;
  std::string plots, notes;
  for (std::size_t i = 0; i < std::min(pairs.size(), kPairsDrawn); ++i) {
    if (has_residual(pairs[i])) {
      plots += fmt::format("<figure data-figure=\"residuals\" data-pair=\"{}\"></figure>", i);
    } else {
      notes += without_residual(pairs[i]);
    }
  }
  if (pairs.size() > kPairsDrawn) {
    notes += fmt::format("<p class=\"note\">{} of {} pairs are drawn; all are in ranges.csv.</p>\n",
                         kPairsDrawn, pairs.size());
  }
  if (plots.empty()) return notes;
  constexpr std::size_t kWideMax = 3;
  return fmt::format(
      "<p class=\"note\">Residual: measured less predicted range, after the bias. Marks at the "
      "upper border lie farther out, marks on the lower border too or have no residual. Where many "
      "lie on one place, one is drawn.</p>\n<div class=\"{}\">{}</div>\n{}",
      pairs.size() > kWideMax ? "plots" : "", plots, notes);
}

}  // namespace

Section ranges_section(const RunData& run) {
  Section section{"ranges", "Ranges", ""};
  if (run.ranges.total.value_or(0.0) <= 0.0 && run.range_table.rows == 0) {
    const std::string why = ranges_unused(run);
    section.html = absent("No range was used: nothing but LiDAR and inertia holds the map." +
                          (why.empty() ? "" : " " + why + "."));
    return section;
  }
  section.html = reasons_table(run) + pairs_table(run) + strangers_note(run);
  if (run.range_table.rows == 0) {
    section.html += absent("There is no ranges.csv: single residuals are not known.");
    return section;
  }
  section.html += residual_plots(run);
  return section;
}

}  // namespace rali::report
