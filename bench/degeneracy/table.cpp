#include "table.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "rali/degeneracy/roc.hpp"
#include "rali/eval/statistics.hpp"

namespace rali::degeneracy_bench {

using degeneracy::Judged;

namespace {

struct Look {
  const char* name;
  double threshold;  ///< default or commonly used value
  double second;     ///< a second one, 0: none
};

constexpr double of_sigma(double sigma_m) { return 1.0 / (sigma_m * sigma_m); }

// Zhang: the value of the LOAM family. lambda3: chosen with 16 rings in an earlier study
// (algorithms 3.4). Times chance: kappa_supported. The last: the sigmas of AwareSettings.
const std::array<Look, kDetectors> kLooks{{{"paper, lambda2/lambda3", 3.0, 0.0},
                                           {"lambda3", 0.0033, 0.0},
                                           {"zhang, 6x6", 100.0, 0.0},
                                           {"zhang, translation", 100.0, 0.0},
                                           {"information I", of_sigma(0.02), of_sigma(0.1)},
                                           {"times chance, I/B", 2.0, 0.0},
                                           {"aware, J", of_sigma(0.02), of_sigma(0.1)}}};

using Pick = std::function<bool(const Sample&)>;

std::vector<Judged> judged(const std::vector<Sample>& samples, std::size_t detector,
                           const Pick& pick) {
  std::vector<Judged> out;
  for (const Sample& s : samples) {
    if (s.truth.wrong_minimum || !pick(s)) continue;
    out.push_back({s.reported[detector].score, s.truth.degenerate});
  }
  return out;
}

bool with_other(const Sample& s) { return s.place.find('+') != std::string::npos; }

/// No other vehicle is in view, or it is masked.
bool plain(const Sample& s) { return s.masked || !with_other(s); }

/// A scene of the simulator, not a tunnel made for this benchmark.
bool scene(const Sample& s) { return s.place.find('_') == std::string::npos; }

std::string rates(const std::vector<Judged>& scans, double threshold) {
  if (threshold <= 0.0) return "-";
  const degeneracy::Rates r = degeneracy::rates_at(scans, threshold);
  return fmt::format("{:.3f}/{:.3f}", r.hit, r.false_alarm);
}

/// Median / 90 % quantile of the angle to the axis over degenerate scans of tunnels.
std::string directions(const std::vector<Sample>& samples, std::size_t detector, int rings) {
  std::vector<double> angles;
  int asked = 0;
  for (const Sample& s : samples) {
    const bool straight = s.place.rfind("tunnel", 0) == 0 || s.place.rfind("corridor", 0) == 0;
    if (!straight || !plain(s) || s.rings != rings || !s.truth.degenerate) continue;
    ++asked;
    if (std::isfinite(s.reported[detector].off_axis_deg)) {
      angles.push_back(s.reported[detector].off_axis_deg);
    }
  }
  if (angles.empty()) return "-";
  return fmt::format("{:.1f} / {:.1f} ({:.0f} %)", eval::quantile(angles, 0.5),
                     eval::quantile(angles, 0.9),
                     100.0 * static_cast<double>(angles.size()) / std::max(1, asked));
}

std::vector<int> rings_of(const std::vector<Sample>& samples) {
  std::vector<int> out;
  for (const Sample& s : samples) out.push_back(s.rings);
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

}  // namespace

std::string detector_table(const std::vector<Sample>& samples) {
  std::string out =
      "| detector | rings | blind/seen | AUC, scenes | vehicles not masked | AUC, all places | "
      "hit at 5 % false | hit/false as set | hit/false at 10 cm | direction deg, median / 90 % "
      "(named) |\n|---|---|---|---|---|---|---|---|---|---|\n";
  for (std::size_t d = 0; d < kDetectors; ++d) {
    for (const int rings : rings_of(samples)) {
      const auto area = [&](const Pick& pick) {
        return degeneracy::roc_of(
                   judged(samples, d, [&](const Sample& s) { return s.rings == rings && pick(s); }))
            .auc;
      };
      const auto all =
          judged(samples, d, [&](const Sample& s) { return plain(s) && s.rings == rings; });
      const degeneracy::Roc roc = degeneracy::roc_of(all);
      out += fmt::format("| {} | {} | {}/{} | {:.3f} | {:.3f} | {:.3f} | {:.3f} | {} | {} | {} |\n",
                         kLooks[d].name, rings, roc.degenerate, roc.seen,
                         area([](const Sample& s) { return scene(s) && plain(s); }),
                         area([](const Sample& s) { return scene(s) && !s.masked; }), roc.auc,
                         roc.hit_at_5, rates(all, kLooks[d].threshold),
                         rates(all, kLooks[d].second), directions(samples, d, rings));
    }
  }
  return out;
}

std::string place_table(const std::vector<Sample>& samples) {
  constexpr auto kAware = static_cast<std::size_t>(Detector::kAware);
  std::string out =
      "| place | blind/seen | AUC | hit/false at 2 cm | hit/false at 10 cm | error of the seen m, "
      "95 % | wrong minimum |\n|---|---|---|---|---|---|---|\n";
  std::vector<std::string> names;
  const auto name_of = [](const Sample& s) { return s.place + (s.masked ? ", masked" : ""); };
  for (const Sample& s : samples) {
    if (std::find(names.begin(), names.end(), name_of(s)) == names.end()) {
      names.push_back(name_of(s));
    }
  }
  for (const std::string& name : names) {
    const auto scans = judged(samples, kAware, [&](const Sample& s) { return name_of(s) == name; });
    const degeneracy::Roc roc = degeneracy::roc_of(scans);
    std::vector<double> errors;
    int wrong = 0;
    for (const Sample& s : samples) {
      if (name_of(s) != name) continue;
      wrong += s.truth.wrong_minimum ? 1 : 0;
      if (!s.truth.degenerate) errors.push_back(s.truth.worst_m);
    }
    const bool both = roc.degenerate > 0 && roc.seen > 0;
    out += fmt::format("| {} | {}/{} | {} | {} | {} | {} | {} |\n", name, roc.degenerate, roc.seen,
                       both ? fmt::format("{:.3f}", roc.auc) : "-", rates(scans, of_sigma(0.02)),
                       rates(scans, of_sigma(0.1)),
                       errors.empty() ? "-" : fmt::format("{:.3f}", eval::quantile(errors, 0.95)),
                       wrong);
  }
  return out;
}

std::string json_of(const std::vector<Sample>& samples) {
  nlohmann::json rows = nlohmann::json::array();
  for (const Sample& s : samples) {
    nlohmann::json row{{"place", s.place},
                       {"masked", s.masked},
                       {"seed", s.seed},
                       {"rings", s.rings},
                       {"driven_m", s.driven_m},
                       {"error_m", s.truth.worst_m},
                       {"blind", s.truth.degenerate},
                       {"wrong_minimum", s.truth.wrong_minimum}};
    for (std::size_t d = 0; d < kDetectors; ++d) {
      const double off = s.reported[d].off_axis_deg;
      row["detectors"][kLooks[d].name] = {
          {"score", s.reported[d].score},
          {"off_axis_deg", std::isfinite(off) ? nlohmann::json(off) : nlohmann::json()}};
    }
    rows.push_back(std::move(row));
  }
  return rows.dump(1) + "\n";
}

}  // namespace rali::degeneracy_bench
