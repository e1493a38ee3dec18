#include "rali/report/data/columns.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace rali::report {
namespace {

/// Rows of different files belong together if their stamps differ by less.
constexpr double kSameTime_s = 1e-3;
/// Speed is averaged over this time: single poses are too noisy.
constexpr double kSpeedSpan_s = 1.0;
/// Slower counts as standstill.
constexpr double kStands_mps = 0.05;
constexpr double kDegPerRad = 57.29577951308232;
/// Larger ratios are clipped: they all mean that the stated covariance is wrong.
constexpr double kRatioMax = 100.0;
constexpr double kDofPose = 6.0;

const float kNone = static_cast<float>(kUnknown);

/// For each time the entry of `list` with that stamp, or null.
template <class Entry>
std::vector<const Entry*> entries_at(const std::vector<double>& t_s,
                                     const std::vector<Entry>& list) {
  std::vector<const Entry*> out(t_s.size(), nullptr);
  std::size_t at = 0;
  for (std::size_t i = 0; i < t_s.size(); ++i) {
    while (at < list.size() && list[at].t_s < t_s[i] - kSameTime_s) ++at;
    if (at < list.size() && list[at].t_s <= t_s[i] + kSameTime_s) out[i] = &list[at];
  }
  return out;
}

template <class Entry, class Get>
std::vector<float> values_of(const std::vector<const Entry*>& entries, Get&& get) {
  std::vector<float> out;
  out.reserve(entries.size());
  for (const Entry* e : entries) out.push_back(e == nullptr ? kNone : static_cast<float>(get(*e)));
  return out;
}

/// Heading of an axis, -90 to 90 degrees: an axis has no sign. Vertical axes have no heading.
double heading_deg(const DegeneracyPoint& d) {
  if (!d.axis.allFinite() || d.axis.head<2>().norm() < 0.5) return kUnknown;
  const double heading = std::atan2(d.axis.y(), d.axis.x()) * kDegPerRad;
  return heading > 90.0 ? heading - 180.0 : heading <= -90.0 ? heading + 180.0 : heading;
}

std::vector<float> distances(const std::vector<const PathPoint*>& poses) {
  std::vector<float> out;
  double sum_m = 0.0;
  const PathPoint* before = nullptr;
  for (const PathPoint* p : poses) {
    if (p != nullptr && before != nullptr) sum_m += (p->p_m - before->p_m).norm();
    if (p != nullptr) before = p;
    out.push_back(static_cast<float>(sum_m));
  }
  return out;
}

std::vector<float> speeds(const std::vector<PathPoint>& path) {
  std::vector<float> out(path.size(), kNone);
  std::size_t back = 0, ahead = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    while (path[back].t_s < path[i].t_s - 0.5 * kSpeedSpan_s) ++back;
    while (ahead + 1 < path.size() && path[ahead].t_s < path[i].t_s + 0.5 * kSpeedSpan_s) ++ahead;
    const double span_s = path[ahead].t_s - path[back].t_s;
    if (span_s < 0.4 * kSpeedSpan_s) continue;
    out[i] = static_cast<float>((path[ahead].p_m - path[back].p_m).norm() / span_s);
  }
  return out;
}

void add_place(const char* const (&names)[3], const std::vector<const PathPoint*>& poses,
               Columns& out) {
  for (int axis = 0; axis < 3; ++axis) {
    out.list.push_back(
        {names[axis], values_of(poses, [&](const PathPoint& w) { return w.p_m[axis]; }), false});
  }
}

void add_errors(const std::vector<const ErrorPoint*>& errors, Columns& out) {
  const auto add = [&](std::string_view name, auto get) {
    out.list.push_back({name, values_of(errors, get)});
  };
  add("ape", [](const ErrorPoint& e) { return e.ape_m; });
  add("rot", [](const ErrorPoint& e) { return e.rot_deg; });
  add("ez", [](const ErrorPoint& e) { return e.e_m.z(); });
  add("along", [](const ErrorPoint& e) { return e.along_degenerate_m; });
  add("ratio", [](const ErrorPoint& e) {
    return std::min(std::sqrt(std::max(e.nees, 0.0) / kDofPose), kRatioMax);
  });
}

std::uint8_t state_of(const DegeneracyPoint* d, float speed_mps) {
  if (d == nullptr) return kStateUnknown;
  const auto bits = static_cast<unsigned>(d->held_by) | static_cast<unsigned>(d->sight) << 2U |
                    (d->degenerate ? unsigned{kDegenerateBit} : 0U) |
                    (static_cast<double>(speed_mps) < kStands_mps ? unsigned{kStandsBit} : 0U);
  return static_cast<std::uint8_t>(bits);
}

/// The worse of each field: enumerators are ordered from good to bad. Standstill only if both rows
/// are.
std::uint8_t worse(std::uint8_t a, std::uint8_t b) {
  if (a == kStateUnknown || b == kStateUnknown) return a == kStateUnknown ? b : a;
  const auto field = [&](unsigned mask) { return std::max(a & mask, b & mask); };
  return static_cast<std::uint8_t>(field(3U) | field(12U) | field(kDegenerateBit) |
                                   (a & b & kStandsBit));
}

/// The two values that represent rows `begin` to `end` - 1.
std::array<float, 2> two_of(const Column& column, std::size_t begin, std::size_t end) {
  if (!column.keeps_extremes) return {column.values[begin], column.values[(begin + end) / 2]};
  std::size_t low = begin, high = begin;
  for (std::size_t i = begin; i < end; ++i) {
    const float v = column.values[i];
    if (!std::isfinite(v)) continue;
    if (!(column.values[low] <= v)) low = i;
    if (!(column.values[high] >= v)) high = i;
  }
  return {column.values[std::min(low, high)], column.values[std::max(low, high)]};
}

}  // namespace

Columns columns_of(const VehicleView& v) {
  std::vector<double> t_s;
  for (const PathPoint& w : v.path) t_s.push_back(w.t_s);
  if (t_s.empty()) {
    for (const DegeneracyPoint& d : v.degeneracy) t_s.push_back(d.t_s);
  }
  Columns out;
  out.list.push_back({"t", std::vector<float>(t_s.begin(), t_s.end()), false});
  const auto poses = entries_at(t_s, v.path);
  const auto degeneracy = entries_at(t_s, v.degeneracy);
  out.list.push_back({"distance", distances(poses), false});
  add_place({"x", "y", "z"}, poses, out);
  add_place({"true_x", "true_y", "true_z"}, entries_at(t_s, v.truth), out);
  std::vector<float> speed =
      v.path.empty() ? std::vector<float>(t_s.size(), kNone) : speeds(v.path);
  for (std::size_t i = 0; i < t_s.size(); ++i) {
    out.state.push_back(state_of(degeneracy[i], speed[i]));
  }
  out.list.push_back({"speed", std::move(speed)});
  out.list.push_back({"sigma", values_of(entries_at(t_s, v.sigmas),
                                         [](const SigmaPoint& p) { return p.sigma_m; })});
  add_errors(entries_at(t_s, v.errors), out);
  const auto add = [&](std::string_view name, auto get) {
    out.list.push_back({name, values_of(degeneracy, get)});
  };
  add("degree", [](const DegeneracyPoint& d) { return d.degree; });
  add("heading", heading_deg);
  add("off", [](const DegeneracyPoint& d) { return d.off_m; });
  std::erase_if(out.list, [](const Column& c) {
    return std::none_of(c.values.begin(), c.values.end(), [](float x) { return std::isfinite(x); });
  });
  return out;
}

void thin(Columns& columns, std::size_t rows_max) {
  const std::size_t n = columns.rows(), stretches = rows_max / 2;
  if (n <= rows_max || stretches == 0) return;
  const auto start_of = [&](std::size_t k) { return k * n / stretches; };
  for (Column& column : columns.list) {
    std::vector<float> kept;
    for (std::size_t k = 0; k < stretches; ++k) {
      for (const float v : two_of(column, start_of(k), start_of(k + 1))) kept.push_back(v);
    }
    column.values = std::move(kept);
  }
  std::vector<std::uint8_t> kept;
  for (std::size_t k = 0; k < stretches; ++k) {
    std::uint8_t state = kStateUnknown;
    for (std::size_t i = start_of(k); i < start_of(k + 1); ++i) {
      state = worse(state, columns.state[i]);
    }
    kept.insert(kept.end(), 2, state);
  }
  columns.state = std::move(kept);
}

}  // namespace rali::report
