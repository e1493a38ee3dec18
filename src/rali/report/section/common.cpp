#include <algorithm>

#include "rali/report/internal/html.hpp"
#include "rali/report/section/section.hpp"

namespace rali::report {

double last_time_s(const RunData& run) {
  double last_s = 0.0;
  for (const VehicleView& v : run.vehicles) {
    if (!v.path.empty()) last_s = std::max(last_s, v.path.back().t_s);
    if (!v.degeneracy.empty()) last_s = std::max(last_s, v.degeneracy.back().t_s);
  }
  return last_s;
}

const PathPoint* pose_near(const std::vector<PathPoint>& path, double t_s) {
  const PathPoint* best = nullptr;
  const auto after = std::lower_bound(path.begin(), path.end(), t_s,
                                      [](const PathPoint& w, double t) { return w.t_s < t; });
  if (after != path.end()) best = &*after;
  if (after != path.begin()) {
    const PathPoint* before = &*std::prev(after);
    if (best == nullptr || t_s - before->t_s < best->t_s - t_s) best = before;
  }
  return best;
}

std::string names_text(const std::vector<std::string>& names) {
  std::string out;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) out += i + 1 == names.size() ? " and " : ", ";
    out += escaped(names[i]);
  }
  return out;
}

Number measured(const RunData& run, std::string_view key) {
  for (const Measured& m : run.evaluation) {
    if (m.key == key && m.value == m.value) return m.value;
  }
  return {};
}

}  // namespace rali::report
