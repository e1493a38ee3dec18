#include "table.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include <fmt/format.h>

#include "rali/eval/statistics.hpp"

namespace rali::tunnel {

namespace {

using Values = std::vector<double>;
using Get = std::function<double(const Scores&)>;
using Group = std::vector<const Scores*>;

enum class Show { kHighIsBad, kLowIsBad, kMean };

struct Column {
  const char* title;
  Get get;
  int digits;
  Show show = Show::kHighIsBad;
};

/// The values that exist.
Values values_of(const Group& group, const Get& get) {
  Values out;
  for (const Scores* s : group) {
    const double v = get(*s);
    if (!std::isnan(v)) out.push_back(v);
  }
  return out;
}

/// Mean over runs; runs are independent, so its 95 % interval is 1.96 sd / sqrt(n) to each side.
std::string mean_text(const Values& values, int digits) {
  const eval::Statistics s = eval::statistics(values);
  if (s.count < 2) return fmt::format("{:.{}f}", s.mean, digits);
  const auto n = static_cast<double>(s.count);
  const double half = 1.96 * s.std / std::sqrt(n - 1.0);
  return fmt::format("{:.{}f} ({:.{}f}-{:.{}f})", s.mean, digits, std::max(0.0, s.mean - half),
                     digits, s.mean + half, digits);
}

/// Quantiles interpolate, which fails for infinities.
double median_of(Values values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  const double high = values[n / 2];
  return n % 2 == 1 || !std::isfinite(high) ? high : 0.5 * (values[n / 2 - 1] + high);
}

std::string cell(const Group& group, const Column& c) {
  const Values values = values_of(group, c.get);
  if (values.empty()) return " - |";
  if (c.show == Show::kMean) return fmt::format(" {} |", mean_text(values, c.digits));
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return fmt::format(" {:.{}f} / {:.{}f} |", median_of(values), c.digits,
                     c.show == Show::kLowIsBad ? *low : *high, c.digits);
}

std::vector<Group> groups_of(const std::vector<Scores>& runs) {
  std::vector<Group> groups;
  for (const Scores& s : runs) {
    const auto same = std::find_if(groups.begin(), groups.end(),
                                   [&](const Group& g) { return g.front()->row == s.row; });
    if (same == groups.end()) {
      groups.push_back({&s});
    } else {
      same->push_back(&s);
    }
  }
  return groups;
}

std::string table(const std::vector<Group>& groups, const std::string& first,
                  const std::vector<Column>& columns) {
  std::string out = fmt::format("| {} |", first);
  std::string line = "|---|";
  for (const Column& c : columns) {
    out += fmt::format(" {} |", c.title);
    line += "---|";
  }
  out += "\n" + line + "\n";
  for (const Group& group : groups) {
    out += fmt::format("| {} ({}) |", group.front()->row, group.size());
    for (const Column& c : columns) out += cell(group, c);
    out += "\n";
  }
  return out;
}

std::vector<Column> accuracy_columns() {
  return {
      {"axis live m", [](const Scores& s) { return s.live.axial_rmse_m; }, 3},
      {"axis smoothed m", [](const Scores& s) { return s.smoothed.axial_rmse_m; }, 3},
      {"unaligned live m", [](const Scores& s) { return s.live.start_rmse_m; }, 3},
      {"unaligned smoothed m", [](const Scores& s) { return s.smoothed.start_rmse_m; }, 3},
      {"lateral m", [](const Scores& s) { return s.live.lateral_rmse_m; }, 3},
      {"vertical m", [](const Scores& s) { return s.live.vertical_rmse_m; }, 3},
      {"most along axis m", [](const Scores& s) { return s.live.axial_max_m; }, 3},
      {"APE live m", [](const Scores& s) { return s.live.ape_rmse_m; }, 3},
      {"APE smoothed m", [](const Scores& s) { return s.smoothed.ape_rmse_m; }, 3},
  };
}

std::vector<Column> range_columns() {
  return {
      {"NEES axis", [](const Scores& s) { return s.live.nees_axial; }, 2, Show::kMean},
      {"NEES 6", [](const Scores& s) { return s.live.nees6; }, 1, Show::kMean},
      {"NEES axis smoothed", [](const Scores& s) { return s.smoothed.nees_axial; }, 2, Show::kMean},
      {"NIS", [](const Scores& s) { return s.nis; }, 2, Show::kMean},
      {"heard", [](const Scores& s) { return s.received; }, 2, Show::kLowIsBad},
      {"bad", [](const Scores& s) { return s.bad; }, 3},
      {"bad refused", [](const Scores& s) { return s.bad_refused; }, 2, Show::kLowIsBad},
      {"good kept", [](const Scores& s) { return s.good_kept; }, 2, Show::kLowIsBad},
      {"blind", [](const Scores& s) { return s.degenerate; }, 2},
      {"growth m", [](const Scores& s) { return s.loss_growth_m; }, 2},
      {"back after s", [](const Scores& s) { return s.loss_back_s; }, 1},
      {"CPU ms", [](const Scores& s) { return s.cpu_ms; }, 1},
      {"p99 ms", [](const Scores& s) { return s.cpu_p99_ms; }, 1},
  };
}

/// The run of the same place without ranges.
const Scores* partner_of(const Scores& with, const std::vector<Scores>& runs) {
  for (const Scores& s : runs) {
    if (!s.ranges && s.seed == with.seed && s.row == with.row + ", ranges off") return &s;
  }
  return nullptr;
}

/// Results with ranges compared with those without, seed by seed.
std::string against_table(const std::vector<Scores>& runs) {
  const auto compared = [&runs](auto compare) -> Get {
    return [&runs, compare](const Scores& s) {
      const Scores* off = partner_of(s, runs);
      return off == nullptr ? kNone : compare(s, *off);
    };
  };
  const auto percent = [](double on, double off) { return 100.0 * (on / off - 1.0); };
  const std::vector<Column> columns{
      {"APE off m", compared([](const Scores&, const Scores& off) { return off.live.ape_rmse_m; }),
       4},
      {"APE on m", [](const Scores& s) { return s.live.ape_rmse_m; }, 4},
      {"change %", compared([=](const Scores& on, const Scores& off) {
         return percent(on.live.ape_rmse_m, off.live.ape_rmse_m);
       }),
       1},
      {"smoothed, change %", compared([=](const Scores& on, const Scores& off) {
         return percent(on.smoothed.ape_rmse_m, off.live.ape_rmse_m);
       }),
       1},
      {"axis, change %", compared([=](const Scores& on, const Scores& off) {
         return percent(on.live.axial_rmse_m, off.live.axial_rmse_m);
       }),
       1},
      {"ranges cost ms",
       compared([](const Scores& on, const Scores& off) { return on.cpu_ms - off.cpu_ms; }), 2}};
  std::vector<Group> groups = groups_of(runs);
  std::erase_if(groups, [&](const Group& g) {
    return !g.front()->ranges || partner_of(*g.front(), runs) == nullptr;
  });
  return groups.empty() ? std::string() : table(groups, "median / worst", columns);
}

std::vector<Column> cloud_columns() {
  return {{"mean m", [](const Scores& s) { return s.cloud_mean_m; }, 4},
          {"sd m", [](const Scores& s) { return s.cloud_sd_m; }, 4},
          {"farther than 1 m", [](const Scores& s) { return s.cloud_beyond; }, 4},
          {"APE smoothed m", [](const Scores& s) { return s.smoothed.ape_rmse_m; }, 4}};
}

}  // namespace

std::string tables_of(const std::string& suite, const std::vector<Scores>& runs) {
  const std::vector<Group> groups = groups_of(runs);
  if (suite == "mesh") return table(groups, "cloud to mesh", cloud_columns());
  std::string out = table(groups, "median / worst", accuracy_columns());
  out += "\n" + table(groups, "mean, or median / worst", range_columns());
  if (const std::string against = against_table(runs); !against.empty()) out += "\n" + against;
  return out;
}

std::string line_of(const Scores& s) {
  std::string out = fmt::format(
      "{} seed {}: axis {:.3f} live, {:.3f} smoothed; unaligned {:.3f}, {:.3f}; most {:.3f} m at "
      "{:.1f} s; NEES {:.2f}, {:.1f}; blind {:.2f}; {:.1f} ms",
      s.row, s.seed, s.live.axial_rmse_m, s.smoothed.axial_rmse_m, s.live.start_rmse_m,
      s.smoothed.start_rmse_m, s.live.axial_max_m, s.t_worst_s, s.live.nees_axial, s.live.nees6,
      s.degenerate, s.cpu_ms);
  if (s.ranges) {
    out += fmt::format("; NIS {:.2f}, bad refused {:.2f}, good kept {:.2f}, heard {:.2f}", s.nis,
                       s.bad_refused, s.good_kept, s.received);
  }
  if (!std::isnan(s.loss_growth_m)) {
    out += fmt::format("; lost {:.2f} m, back after {:.1f} s", s.loss_growth_m, s.loss_back_s);
  }
  if (!std::isnan(s.cloud_mean_m)) {
    out += fmt::format("; cloud {:.4f} +- {:.4f} m", s.cloud_mean_m, s.cloud_sd_m);
  }
  if (s.diverged > 0) out += fmt::format("; {} poses diverged", s.diverged);
  return out;
}

}  // namespace rali::tunnel
