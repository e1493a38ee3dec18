#include "rali/eval/errors.hpp"

#include <algorithm>
#include <cmath>

namespace rali::eval {

using geometry::SE3;
using geometry::Vec3;

namespace {

PoseError error_of(Time t, const SE3& E) { return {t, E.p.norm(), geometry::so3_log(E.R).norm()}; }

/// Length of the step that ends at each pair.
std::vector<double> steps(const PairList& pairs, bool of_estimate) {
  std::vector<double> out(pairs.size(), 0.0);
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    out[i] = of_estimate ? (pairs[i].est.p - pairs[i - 1].est.p).norm()
                         : (pairs[i].ref.p - pairs[i - 1].ref.p).norm();
  }
  return out;
}

/// Path length up to each pair.
std::vector<double> path(const PairList& pairs, bool of_estimate = false) {
  std::vector<double> s = steps(pairs, of_estimate);
  for (std::size_t i = 1; i < s.size(); ++i) s[i] += s[i - 1];
  return s;
}

/// The first index after i whose distance along the path from i is nearest to distance_m.
std::size_t end_of_piece(const std::vector<double>& s, std::size_t i, double distance_m) {
  const auto off = [&](std::size_t k) { return std::abs((s[k] - s[i]) - distance_m); };
  const auto first = s.begin() + static_cast<std::ptrdiff_t>(i) + 1;
  const auto after = std::lower_bound(first, s.end(), s[i] + distance_m);
  if (after == first) return i + 1;
  // At standstill the path length does not grow: the first of equal ones counts.
  const auto before = std::lower_bound(first, s.end(), *(after - 1));
  const auto b = static_cast<std::size_t>(before - s.begin());
  if (after == s.end()) return b;
  const auto a = static_cast<std::size_t>(after - s.begin());
  return off(b) <= off(a) ? b : a;
}

/// Ends of pieces of at least distance_m; the length restarts at each end.
std::vector<std::size_t> ends_of_pieces(const std::vector<double>& steps, double distance_m) {
  std::vector<std::size_t> ends;
  double piece_m = 0.0;
  for (std::size_t i = 1; i < steps.size(); ++i) {
    piece_m += steps[i];
    if (piece_m < distance_m) continue;
    ends.push_back(i);
    piece_m = 0.0;
  }
  return ends;
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
  if (!(options.distance_m > 0.0)) return {};
  std::vector<PoseError> out;
  const auto add = [&](std::size_t i, std::size_t j) {
    const SE3 Q = pairs[i].ref.inverse() * pairs[j].ref;
    const SE3 P = pairs[i].est.inverse() * pairs[j].est;
    out.push_back(error_of(pairs[i].t, Q.inverse() * P));
  };
  if (!options.all_pairs) {
    const std::vector<std::size_t> ends =
        ends_of_pieces(steps(pairs, options.along_estimate), options.distance_m);
    for (std::size_t k = 1; k < ends.size(); ++k) add(ends[k - 1], ends[k]);
    return out;
  }
  const std::vector<double> s = path(pairs, options.along_estimate);
  const double tolerance_m = options.tolerance * options.distance_m;
  for (std::size_t i = 0; i + 1 < pairs.size(); ++i) {
    const std::size_t j = end_of_piece(s, i, options.distance_m);
    if (std::abs((s[j] - s[i]) - options.distance_m) <= tolerance_m) add(i, j);
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

std::vector<double> along_path_errors(const PairList& pairs, const SE3& T_ref_est, double chord_m) {
  const std::vector<double> s = path(pairs);
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

double path_length_m(const PairList& pairs) { return pairs.empty() ? 0.0 : path(pairs).back(); }

}  // namespace rali::eval
