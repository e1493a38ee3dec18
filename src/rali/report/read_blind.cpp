#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "rali/report/internal/read_parts.hpp"
#include "rali/report/internal/table_rows.hpp"

namespace rali::report {
namespace {

/// Spans that are nearer than this are one: a single seen sweep between blind ones says nothing.
constexpr double kBlindJoin_s = 0.5;
constexpr double kSameStamp_s = 1e-4;
/// Shorter steps are noise and have no direction.
constexpr double kStepOfMotion_m = 0.5;
/// Sweeps farther apart were not mapped: no way is counted between them.
constexpr double kCut_s = 2.0;
/// A range holds so long (algorithms 4.3): what is later was not heard.
constexpr double kHeard_s = 2.0;
constexpr std::size_t kNamesMax = 64, kNameBytesMax = 64;

HeldBy held_by_of(const std::string& word, const DegeneracyPoint& d) {
  if (word == "lidar") return HeldBy::kLidar;
  if (word == "range") return HeldBy::kRange;
  if (word == "imu") return HeldBy::kImu;
  if (!d.blind && word != "nothing") return HeldBy::kLidar;
  return word.empty() && d.range_from > 0 ? HeldBy::kRange : HeldBy::kNothing;
}

Sight sight_of(const std::string& word, bool blind) {
  if (word == "full") return Sight::kFull;
  if (word == "partial") return Sight::kPartial;
  return word == "none" || blind ? Sight::kNone : Sight::kFull;
}

/// Place of a name, from 1; 0: none.
std::uint16_t number_of(const std::string& name, std::vector<std::string>& names) {
  if (name.empty()) return 0;
  auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    // More are no fleet: they share the last place.
    if (names.size() < kNamesMax) {
      names.push_back(names.size() + 1 < kNamesMax ? name.substr(0, kNameBytesMax) : "others");
    }
    found = names.end() - 1;
  }
  return static_cast<std::uint16_t>(found - names.begin() + 1);
}

void read_points(const std::string& dir, Time t_begin, VehicleView& v, RunData& run) {
  const std::string name = "degeneracy/" + v.name + ".csv";
  read_table(dir, name, run, [&](const TableRow& row) {
    DegeneracyPoint d;
    d.t_s = row.seconds("stamp_s", t_begin);
    d.blind = row.flag("degenerate");
    d.degree = row.number("degree");
    d.axis = {row.number("dir_x"), row.number("dir_y"), row.number("dir_z")};
    const double length = d.axis.norm();
    d.axis = length > 0.5 && length < 2.0 ? geometry::Vec3(d.axis / length)
                                          : geometry::Vec3::Constant(kUnknown);
    // The covariance of the final pose, if it is there, replaces these.
    d.off_m = row.number("sigma_m");
    if (!std::isfinite(d.off_m) && d.blind) d.off_m = row.number("sigma_degenerate_m");
    d.range_from = number_of(row.text("range_from"), v.blind_way.range_names);
    d.held_by = held_by_of(row.text("constrained_by"), d);
    d.sight = sight_of(row.text("category"), d.blind);
    if (std::isfinite(d.t_s)) v.degeneracy.push_back(d);
  });
  v.blind_way.known = !v.degeneracy.empty();
}

/// What the covariance of the final pose says along the axis seen worst.
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

/// Way within a span, and whether it went along the axis.
void add_motion(const VehicleView& v, BlindSpan& span) {
  double along_m = 0.0, sum_m = 0.0;
  const WayPoint* from = nullptr;
  const WayPoint* before = nullptr;
  auto at = std::lower_bound(v.way.begin(), v.way.end(), span.begin_s - kSameStamp_s,
                             [](const WayPoint& w, double t) { return w.t_s < t; });
  for (; at != v.way.end() && at->t_s <= span.end_s + kSameStamp_s; ++at) {
    if (before != nullptr) span.way_m += (at->p_m - before->p_m).norm();
    before = &*at;
    if (from == nullptr) from = before;
    const geometry::Vec3 step_m = at->p_m - from->p_m;
    if (step_m.norm() < kStepOfMotion_m) continue;
    along_m += std::abs(step_m.dot(span.axis));
    sum_m += step_m.norm();
    from = before;
  }
  if (sum_m > 0.0 && span.axis.norm() > 0.5) span.along_way = along_m / sum_m;
}

/// Collects the sweeps of one span.
class SpanMaker {
 public:
  SpanMaker(const VehicleView& v, const DegeneracyPoint& first) : v_(v) {
    span_.begin_s = first.t_s;
    span_.off_begin_m = first.off_m;
  }

  void add(const DegeneracyPoint& d) {
    span_.end_s = d.t_s;
    // An axis has no sign.
    if (d.axis.allFinite()) span_.axis += span_.axis.dot(d.axis) < 0.0 ? -d.axis : d.axis;
    if (std::isfinite(d.off_m) && !(d.off_m <= span_.off_max_m)) span_.off_max_m = d.off_m;
    if (d.range_from > 0) named_[d.range_from] = true;
    span_.held_share[static_cast<std::size_t>(d.held_by)] += 1.0;
    ++sweeps_;
  }

  [[nodiscard]] double end_s() const { return span_.end_s; }

  [[nodiscard]] BlindSpan finish() {
    for (double& share : span_.held_share) share /= static_cast<double>(sweeps_);
    for (std::size_t i = 0; i < v_.blind_way.range_names.size(); ++i) {
      if (!named_[i + 1]) continue;
      span_.held_by += (span_.held_by.empty() ? "" : ", ") + v_.blind_way.range_names[i];
    }
    if (span_.axis.norm() > 0.0) span_.axis.normalize();
    add_motion(v_, span_);
    return span_;
  }

 private:
  const VehicleView& v_;
  BlindSpan span_;
  std::array<bool, kNamesMax + 1> named_{};
  std::size_t sweeps_ = 0;
};

void find_blind_spans(VehicleView& v) {
  std::optional<SpanMaker> maker;
  bool was_blind = false;
  for (const DegeneracyPoint& d : v.degeneracy) {
    const double join_s = std::exchange(was_blind, d.blind) ? kCut_s : kBlindJoin_s;
    if (!d.blind) continue;
    if (maker && std::abs(d.t_s - maker->end_s()) > join_s) {
      v.blind.push_back(maker->finish());
      maker.reset();
    }
    if (!maker) maker.emplace(v, d);
    maker->add(d);
  }
  if (maker) v.blind.push_back(maker->finish());
}

/// Whether a range was heard around a time; times come in order.
class HeardNear {
 public:
  explicit HeardNear(const std::vector<Heard>& heard) : heard_(heard) {}

  [[nodiscard]] bool at(double t_s) {
    while (at_ < heard_.size() && heard_[at_].end_s + kHeard_s < t_s) ++at_;
    return at_ < heard_.size() && heard_[at_].begin_s - kHeard_s <= t_s;
  }

 private:
  const std::vector<Heard>& heard_;
  std::size_t at_ = 0;
};

/// Way to each sweep of the degeneracy file from the pose before it, by their stamps.
class StepOf {
 public:
  explicit StepOf(const std::vector<WayPoint>& way) : way_(way) {}

  [[nodiscard]] double m(double t_s) {
    while (at_ < way_.size() && way_[at_].t_s < t_s - kSameStamp_s) ++at_;
    if (at_ == 0 || at_ == way_.size() || way_[at_].t_s > t_s + kSameStamp_s) return 0.0;
    if (!(way_[at_].t_s - way_[at_ - 1].t_s <= kCut_s)) return 0.0;
    return (way_[at_].p_m - way_[at_ - 1].p_m).norm();
  }

 private:
  const std::vector<WayPoint>& way_;
  std::size_t at_ = 0;
};

}  // namespace

void OffPeak::see(double value_m, double at_s) {
  if (!std::isfinite(value_m) || value_m <= off_m) return;
  off_m = value_m;
  t_s = at_s;
}

void read_blind(const std::string& dir, Time t_begin, VehicleView& v, RunData& run) {
  read_points(dir, t_begin, v, run);
  find_errors_along_axes(v);
  find_blind_spans(v);
}

void sum_blind_way(VehicleView& v) {
  HeardNear heard(v.heard);
  StepOf step_of(v.way);
  BlindWay& way = v.blind_way;
  double before_s = kUnknown;
  for (const DegeneracyPoint& d : v.degeneracy) {
    const double dt_s = d.t_s - before_s;
    const WayShare step{step_of.m(d.t_s), dt_s > 0.0 && dt_s <= kCut_s ? dt_s : 0.0};
    before_s = d.t_s;
    way.all.add(step);
    if (!d.blind) continue;
    way.blind.add(step);
    way.held[static_cast<std::size_t>(d.held_by)].add(step);
    way.peak.see(d.off_m, d.t_s);
    if (d.held_by == HeldBy::kNothing) way.peak_nothing.see(d.off_m, d.t_s);
    if (!heard.at(d.t_s)) way.unheard.add(step);
  }
}

}  // namespace rali::report
