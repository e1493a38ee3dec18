#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "rali/report/internal/read_parts.hpp"
#include "rali/report/internal/table_rows.hpp"

namespace rali::report {
namespace {

/// Closer spans are merged: a single observable scan between degenerate ones is not significant.
constexpr double kDegenerateJoin_s = 0.5;
constexpr double kSameStamp_s = 1e-4;
/// The direction of shorter steps is noise.
constexpr double kStepOfMotion_m = 0.5;
/// Longer gaps between scans were not mapped: no distance is counted across them.
constexpr double kCut_s = 2.0;
/// A range constrains for this long (algorithms 4.3); later it counts as not received.
constexpr double kReceived_s = 2.0;
constexpr std::size_t kNamesMax = 64, kNameBytesMax = 64;

HeldBy held_by_of(const std::string& word, const DegeneracyPoint& d) {
  if (word == "lidar") return HeldBy::kLidar;
  if (word == "range") return HeldBy::kRange;
  if (word == "imu") return HeldBy::kImu;
  if (!d.degenerate && word != "nothing") return HeldBy::kLidar;
  return word.empty() && d.range_from > 0 ? HeldBy::kRange : HeldBy::kNothing;
}

Sight sight_of(const std::string& word, bool degenerate) {
  if (word == "full") return Sight::kFull;
  if (word == "partial") return Sight::kPartial;
  return word == "none" || degenerate ? Sight::kNone : Sight::kFull;
}

/// Position of a name, from 1; 0: none.
std::uint16_t number_of(const std::string& name, std::vector<std::string>& names) {
  if (name.empty()) return 0;
  auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    // No fleet has more: they share the last entry.
    if (names.size() < kNamesMax) {
      names.push_back(names.size() + 1 < kNamesMax ? name.substr(0, kNameBytesMax) : "others");
    }
    found = names.end() - 1;
  }
  return static_cast<std::uint16_t>(found - names.begin() + 1);
}

void read_points(const std::string& dir, Time t_start, VehicleView& v, RunData& run) {
  const std::string name = "degeneracy/" + v.name + ".csv";
  read_table(dir, name, run, [&](const TableRow& row) {
    DegeneracyPoint d;
    d.t_s = row.seconds("stamp_s", t_start);
    d.degenerate = row.flag("degenerate");
    d.degree = row.number("degree");
    d.axis = {row.number("dir_x"), row.number("dir_y"), row.number("dir_z")};
    const double length = d.axis.norm();
    d.axis = length > 0.5 && length < 2.0 ? geometry::Vec3(d.axis / length)
                                          : geometry::Vec3::Constant(kUnknown);
    // Replaced by the covariance of the final pose, if present.
    d.off_m = row.number("sigma_m");
    if (!std::isfinite(d.off_m) && d.degenerate) d.off_m = row.number("sigma_degenerate_m");
    d.range_from = number_of(row.text("range_from"), v.degenerate_path.range_names);
    d.held_by = held_by_of(row.text("constrained_by"), d);
    d.sight = sight_of(row.text("category"), d.degenerate);
    if (std::isfinite(d.t_s)) v.degeneracy.push_back(d);
  });
  v.degenerate_path.known = !v.degeneracy.empty();
}

/// Expected error from the final pose's covariance along the least observable axis.
void find_errors_along_axes(VehicleView& v) {
  std::size_t at = 0;
  for (DegeneracyPoint& d : v.degeneracy) {
    while (at < v.sigmas.size() && v.sigmas[at].t_s < d.t_s - kSameStamp_s) ++at;
    if (at == v.sigmas.size()) return;
    if (v.sigmas[at].t_s > d.t_s + kSameStamp_s) continue;
    const double off_m = v.sigmas[at].along_m(d.axis);
    if (std::isfinite(off_m)) d.off_m = off_m;
  }
}

/// Distance within a span, and the mean alignment of the motion with the axis.
void add_motion(const VehicleView& v, DegenerateSpan& span) {
  double along_m = 0.0, sum_m = 0.0;
  const PathPoint* from = nullptr;
  const PathPoint* before = nullptr;
  auto at = std::lower_bound(v.path.begin(), v.path.end(), span.start_s - kSameStamp_s,
                             [](const PathPoint& w, double t) { return w.t_s < t; });
  for (; at != v.path.end() && at->t_s <= span.end_s + kSameStamp_s; ++at) {
    if (before != nullptr) span.path_m += (at->p_m - before->p_m).norm();
    before = &*at;
    if (from == nullptr) from = before;
    const geometry::Vec3 step_m = at->p_m - from->p_m;
    if (step_m.norm() < kStepOfMotion_m) continue;
    along_m += std::abs(step_m.dot(span.axis));
    sum_m += step_m.norm();
    from = before;
  }
  if (sum_m > 0.0 && span.axis.norm() > 0.5) span.along_path = along_m / sum_m;
}

/// Collects the scans of one span.
class SpanMaker {
 public:
  SpanMaker(const VehicleView& v, const DegeneracyPoint& first) : v_(v) {
    span_.start_s = first.t_s;
    span_.off_start_m = first.off_m;
  }

  void add(const DegeneracyPoint& d) {
    span_.end_s = d.t_s;
    // An axis has no sign.
    if (d.axis.allFinite()) span_.axis += span_.axis.dot(d.axis) < 0.0 ? -d.axis : d.axis;
    if (std::isfinite(d.off_m) && !(d.off_m <= span_.off_max_m)) span_.off_max_m = d.off_m;
    if (d.range_from > 0) named_[d.range_from] = true;
    span_.held_fraction[static_cast<std::size_t>(d.held_by)] += 1.0;
    ++scans_;
  }

  [[nodiscard]] double end_s() const { return span_.end_s; }

  [[nodiscard]] DegenerateSpan finish() {
    for (double& fraction : span_.held_fraction) fraction /= static_cast<double>(scans_);
    for (std::size_t i = 0; i < v_.degenerate_path.range_names.size(); ++i) {
      if (!named_[i + 1]) continue;
      span_.held_by += (span_.held_by.empty() ? "" : ", ") + v_.degenerate_path.range_names[i];
    }
    if (span_.axis.norm() > 0.0) span_.axis.normalize();
    add_motion(v_, span_);
    return span_;
  }

 private:
  const VehicleView& v_;
  DegenerateSpan span_;
  std::array<bool, kNamesMax + 1> named_{};
  std::size_t scans_ = 0;
};

void find_degenerate_spans(VehicleView& v) {
  std::optional<SpanMaker> maker;
  bool was_degenerate = false;
  for (const DegeneracyPoint& d : v.degeneracy) {
    const double join_s = std::exchange(was_degenerate, d.degenerate) ? kCut_s : kDegenerateJoin_s;
    if (!d.degenerate) continue;
    if (maker && std::abs(d.t_s - maker->end_s()) > join_s) {
      v.degenerate.push_back(maker->finish());
      maker.reset();
    }
    if (!maker) maker.emplace(v, d);
    maker->add(d);
  }
  if (maker) v.degenerate.push_back(maker->finish());
}

/// Whether a range was received around a time; times must be ascending.
class ReceivedNear {
 public:
  explicit ReceivedNear(const std::vector<Received>& received) : received_(received) {}

  [[nodiscard]] bool at(double t_s) {
    while (at_ < received_.size() && received_[at_].end_s + kReceived_s < t_s) ++at_;
    return at_ < received_.size() && received_[at_].start_s - kReceived_s <= t_s;
  }

 private:
  const std::vector<Received>& received_;
  std::size_t at_ = 0;
};

/// Distance to each scan of the degeneracy file from the previous pose, by their stamps.
class StepOf {
 public:
  explicit StepOf(const std::vector<PathPoint>& path) : path_(path) {}

  [[nodiscard]] double m(double t_s) {
    while (at_ < path_.size() && path_[at_].t_s < t_s - kSameStamp_s) ++at_;
    if (at_ == 0 || at_ == path_.size() || path_[at_].t_s > t_s + kSameStamp_s) return 0.0;
    if (!(path_[at_].t_s - path_[at_ - 1].t_s <= kCut_s)) return 0.0;
    return (path_[at_].p_m - path_[at_ - 1].p_m).norm();
  }

 private:
  const std::vector<PathPoint>& path_;
  std::size_t at_ = 0;
};

}  // namespace

void OffPeak::see(double value_m, double at_s) {
  if (!std::isfinite(value_m) || value_m <= off_m) return;
  off_m = value_m;
  t_s = at_s;
}

void read_degenerate(const std::string& dir, Time t_start, VehicleView& v, RunData& run) {
  read_points(dir, t_start, v, run);
  find_errors_along_axes(v);
  find_degenerate_spans(v);
}

void sum_degenerate_path(VehicleView& v) {
  ReceivedNear received(v.received);
  StepOf step_of(v.path);
  DegeneratePath& path = v.degenerate_path;
  double before_s = kUnknown;
  for (const DegeneracyPoint& d : v.degeneracy) {
    const double dt_s = d.t_s - before_s;
    const PathFraction step{step_of.m(d.t_s), dt_s > 0.0 && dt_s <= kCut_s ? dt_s : 0.0};
    before_s = d.t_s;
    path.all.add(step);
    if (!d.degenerate) continue;
    path.degenerate.add(step);
    path.held[static_cast<std::size_t>(d.held_by)].add(step);
    path.peak.see(d.off_m, d.t_s);
    if (d.held_by == HeldBy::kNothing) path.peak_nothing.see(d.off_m, d.t_s);
    if (!received.at(d.t_s)) path.without_range.add(step);
  }
}

}  // namespace rali::report
