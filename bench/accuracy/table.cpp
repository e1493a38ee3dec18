#include "table.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <span>

#include <fmt/format.h>

#include "rali/eval/statistics.hpp"

namespace rali::accuracy {

namespace {

struct Column {
  const char* title;
  double Scores::*value;
  int digits;
  bool low_is_bad;
};

constexpr std::array<Column, 14> kColumns{{{"APE rmse m", &Scores::ape_rmse_m, 3, false},
                                           {"APE max m", &Scores::ape_max_m, 3, false},
                                           {"z rmse m", &Scores::z_rmse_m, 3, false},
                                           {"slip rmse m", &Scores::slip_rmse_m, 3, false},
                                           {"end m", &Scores::end_m, 3, false},
                                           {"RPE 10 m m", &Scores::rpe10_m, 3, false},
                                           {"RPE 10 m deg", &Scores::rpe10_deg, 2, false},
                                           {"NEES 6", &Scores::nees6, 1, false},
                                           {"NEES 3", &Scores::nees3, 1, false},
                                           {"in 95 %", &Scores::fraction95, 2, true},
                                           {"CPU ms", &Scores::cpu_ms, 1, false},
                                           {"p99 ms", &Scores::cpu_p99_ms, 1, false},
                                           {"peak MB", &Scores::peak_mb, 0, false},
                                           {"way m", &Scores::path_m, 0, true}}};

std::string heading(const char* first, std::span<const Column> columns) {
  std::string titles = fmt::format("| {} |", first);
  std::string line = "|---|";
  for (const Column& c : columns) {
    titles += fmt::format(" {} |", c.title);
    line += "---|";
  }
  return titles + " weak | diverged | poses |\n" + line + "---|---|---|\n";
}

std::string summary(const std::vector<Scores>& runs, std::span<const Column> columns) {
  std::string out = heading("median / worst", columns);
  std::vector<bool> done(runs.size(), false);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (done[i]) continue;
    std::vector<Scores> group;
    for (std::size_t k = i; k < runs.size(); ++k) {
      if (runs[k].scene != runs[i].scene || runs[k].preset != runs[i].preset) continue;
      group.push_back(runs[k]);
      done[k] = true;
    }
    out += fmt::format("| {} {} ({}) |", runs[i].scene, runs[i].preset, group.size());
    for (const Column& c : columns) {
      std::vector<double> values;
      for (const Scores& s : group) values.push_back(s.*c.value);
      const auto [low, high] = std::minmax_element(values.begin(), values.end());
      out += fmt::format(" {:.{}f} / {:.{}f} |", eval::quantile(values, 0.5), c.digits,
                         c.low_is_bad ? *low : *high, c.digits);
    }
    std::size_t weak = 0;
    std::size_t diverged = 0;
    std::size_t poses = 0;
    std::size_t scans = 0;
    for (const Scores& s : group) {
      weak += s.weak;
      diverged += s.diverged;
      poses += s.poses;
      scans += s.scans;
    }
    out += fmt::format(" {} | {} | {}/{} |\n", weak, diverged, poses, scans);
  }
  return out;
}

}  // namespace

std::string run_table(const std::vector<Scores>& runs) {
  std::string out = heading("run", kColumns);
  for (const Scores& s : runs) {
    out += fmt::format("| {} {} {} |", s.scene, s.seed, s.preset);
    for (const Column& c : kColumns) out += fmt::format(" {:.{}f} |", s.*c.value, c.digits);
    out += fmt::format(" {} | {} | {}/{} |\n", s.weak, s.diverged, s.poses, s.scans);
  }
  return out;
}

std::string summary_table(const std::vector<Scores>& runs) { return summary(runs, kColumns); }

std::string table_of(const std::vector<Scores>& runs, const std::vector<std::string>& titles) {
  std::vector<Column> columns;
  for (const Column& c : kColumns) {
    if (std::find(titles.begin(), titles.end(), c.title) != titles.end()) columns.push_back(c);
  }
  return summary(runs, columns);
}

}  // namespace rali::accuracy
