#include "table.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace rali::recognition {
namespace {

double quantile(std::vector<double> v, double q) {
  if (v.empty()) return std::nan("");
  std::sort(v.begin(), v.end());
  return v[std::min(v.size() - 1, static_cast<std::size_t>(q * static_cast<double>(v.size())))];
}

double mean(const std::vector<double>& v) {
  double sum = 0.0;
  for (const double x : v) sum += x;
  return v.empty() ? std::nan("") : sum / static_cast<double>(v.size());
}

std::string fraction(int part, int whole) {
  return whole > 0 ? fmt::format("{:.2f}", static_cast<double>(part) / whole) : "-";
}

void outcomes(const std::vector<Figures>& figures, bool guided, std::string& out) {
  out += guided ? "\nWith a guess, pairs of one place.\n\n" : "\nWithout a guess.\n\n";
  out +=
      "| scene | pairs, same place | others | full rank | along an axis | ambiguous | "
      "wrong, full rank | wrong | error median, 95 % (mm) | (deg) | NEES per dof mean, 95 % | ms "
      "|\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const Figures& f : figures) {
    const Outcome& o = guided ? f.guided : f.global;
    out += fmt::format(
        "| {} | {} | {} | {} | {} | {} | {} | {} | {:.0f}, {:.0f} | {:.3f}, {:.3f} | {:.2f}, "
        "{:.2f} "
        "| {:.0f} |\n",
        f.scene, o.same, o.other, o.full, o.along, o.ambiguous, o.wrong_full, o.wrong,
        1e3 * quantile(o.error_m, 0.5), 1e3 * quantile(o.error_m, 0.95), quantile(o.error_deg, 0.5),
        quantile(o.error_deg, 0.95), mean(o.nees), quantile(o.nees, 0.95),
        o.ms / std::max(1, o.same + o.other));
  }
}

}  // namespace

std::string tables(const std::vector<Figures>& figures) {
  std::string out =
      "| scene | pieces | recall of candidates | precision | submap ms | descriptor ms | align ms "
      "mean, 95 % |\n|---|---|---|---|---|---|---|\n";
  for (const Figures& f : figures) {
    out += fmt::format("| {} | {} | {} of {} | {} | {:.0f} | {:.1f} | {:.1f}, {:.1f} |\n", f.scene,
                       f.pieces, f.recalled, f.asked, fraction(f.right, f.candidates), f.make_ms,
                       f.describe_ms, mean(f.align_ms), quantile(f.align_ms, 0.95));
  }
  outcomes(figures, false, out);
  outcomes(figures, true, out);
  return out;
}

std::string table_of(const std::vector<Stages>& stages) {
  std::string out =
      "| scene | pairs, same place | candidate | start near | registered home | believed | best | "
      "usable | at truth: refused by convergence, residuals, overlap, conflict "
      "|\n|---|---|---|---|---|---|---|---|---|\n";
  for (const Stages& s : stages) {
    const auto& r = s.refused_at_truth;
    out += fmt::format("| {} | {} | {} | {} | {} | {} | {} | {} | {}, {}, {}, {} |\n", s.scene,
                       s.same, s.candidate, s.start, s.home, s.assumed, s.best, s.usable, r[1],
                       r[2], r[3], r[4]);
  }
  return out;
}

}  // namespace rali::recognition
