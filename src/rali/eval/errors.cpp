#include "rali/eval/errors.hpp"

#include <algorithm>
#include <cmath>

namespace rali::eval {

using geometry::SE3;
using geometry::Vec3;

namespace {

PoseError error_of(Time t, const SE3& E) { return {t, E.p.norm(), geometry::so3_log(E.R).norm()}; }

/// Way along the reference up to each pair.
std::vector<double> way(const PairList& pairs) {
  std::vector<double> s(pairs.size(), 0.0);
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    s[i] = s[i - 1] + (pairs[i].ref.p - pairs[i - 1].ref.p).norm();
  }
  return s;
}

}  // namespace

std::vector<PoseError> absolute_errors(const PairList& pairs, const SE3& T_ref_est) {
  std::vector<PoseError> out;
  out.reserve(pairs.size());
  for (const PosePair& p : pairs) {
    out.push_back(error_of(p.t, p.ref.inverse() * (T_ref_est * p.est)));
  }
  return out;
}

std::vector<PoseError> relative_errors(const PairList& pairs, const RelativeOptions& options) {
  const std::vector<double> s = way(pairs);
  std::vector<PoseError> out;
  for (std::size_t i = 0; i + 1 < pairs.size();) {
    const double wanted = s[i] + options.distance_m;
    const auto after =
        std::lower_bound(s.begin() + static_cast<std::ptrdiff_t>(i) + 1, s.end(), wanted);
    if (after == s.end() && s.back() < wanted - options.tolerance * options.distance_m) break;
    auto j = static_cast<std::size_t>(after - s.begin());
    if (after == s.end() || (j > i + 1 && wanted - s[j - 1] < s[j] - wanted)) --j;
    const bool fits = std::abs(s[j] - wanted) <= options.tolerance * options.distance_m;
    if (fits) {
      const SE3 Q = pairs[i].ref.inverse() * pairs[j].ref;
      const SE3 P = pairs[i].est.inverse() * pairs[j].est;
      out.push_back(error_of(pairs[i].t, Q.inverse() * P));
    }
    i = options.all_pairs ? i + 1 : j;
  }
  return out;
}

std::vector<double> axis_errors(const PairList& pairs, const SE3& T_ref_est, const Vec3& axis_ref) {
  const Vec3 axis = axis_ref.normalized();
  std::vector<double> out;
  out.reserve(pairs.size());
  for (const PosePair& p : pairs) out.push_back(axis.dot(T_ref_est * p.est.p - p.ref.p));
  return out;
}

std::vector<double> along_way_errors(const PairList& pairs, const SE3& T_ref_est, double chord_m) {
  const std::vector<double> s = way(pairs);
  std::vector<double> out(pairs.size(), 0.0);
  std::size_t back = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    while (back < i && s[i] - s[back + 1] >= chord_m) ++back;
    const Vec3 chord = pairs[i].ref.p - pairs[back].ref.p;
    if (s[i] < chord_m || chord.norm() <= 0.0) continue;
    out[i] = chord.normalized().dot(T_ref_est * pairs[i].est.p - pairs[i].ref.p);
  }
  return out;
}

Statistics translation_statistics(const std::vector<PoseError>& errors) {
  std::vector<double> values;
  values.reserve(errors.size());
  for (const PoseError& e : errors) values.push_back(e.translation_m);
  return statistics(std::move(values));
}

Statistics rotation_statistics(const std::vector<PoseError>& errors) {
  std::vector<double> values;
  values.reserve(errors.size());
  for (const PoseError& e : errors) values.push_back(e.rotation_rad);
  return statistics(std::move(values));
}

double way_length_m(const PairList& pairs) { return pairs.empty() ? 0.0 : way(pairs).back(); }

}  // namespace rali::eval
