#include "rali/fleet/centre/joint_ranges.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <tuple>

namespace rali::fleet {

namespace {

/// A range measurement: pair, time.
using Key = std::tuple<AntennaPair, Time>;

struct Reported {
  const RangeEntry* by_a = nullptr;
  const RangeEntry* by_b = nullptr;
};

std::optional<std::size_t> index_of(std::span<const VehiclePath> paths, VehicleId vehicle) {
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (paths[i].vehicle() == vehicle) return i;
  }
  return std::nullopt;
}

/// Pose of an end; a pose reported with the range is more accurate than the path between nodes.
std::optional<RangeEnd> end_of(const VehiclePath& path, std::uint8_t antenna, Time t,
                               const RangeEntry* reported) {
  if (antenna >= path.antennas_body_m().size()) return std::nullopt;
  const std::optional<PathPlace> place = path.at(t);
  if (!place) return std::nullopt;
  RangeEnd end;
  end.place = *place;
  if (reported != nullptr) end.place.T_odom_body = reported->T_odom_body;
  end.p_odom_m = end.place.T_odom_body * path.antennas_body_m()[antenna];
  const Increment& before = *path.nodes()[place->node].step;
  end.at_rest = reported != nullptr ? reported->at_rest : before.at_rest;
  if (end.at_rest) {
    end.v_odom_mps = geometry::Vec3::Zero();
    return end;
  }
  const std::size_t next = std::min(place->node + 1, path.nodes().size() - 1);
  const Increment& after = *path.nodes()[next].step;
  if (before.levelled && after.levelled) {
    end.v_odom_mps = (1.0 - place->alpha) * before.v_odom_mps + place->alpha * after.v_odom_mps;
  }
  // Facts do not contain the sigma of the speed; this is about what a filter states with ranges.
  constexpr double kKnown_mps = 0.03, kDegenerate_mps = 0.12;
  end.speed_sigma_mps = before.degenerate || after.degenerate ? kDegenerate_mps : kKnown_mps;
  return end;
}

/// Drops repeated values of a frozen radio: ranges of one pair, in order of time, that equal the
/// previous one to the last digit although the ends have moved. At standstill a repetition does no
/// harm.
class Repetitions {
 public:
  /// @return whether this range is one
  bool is_one(const JointRange& range) {
    if (!first_ || first_->pair != range.pair || first_->range_m != range.range_m) {
      first_ = range;
      return false;
    }
    constexpr double kMoved_m = 0.1;  // a radio that rounds to this step repeats values, too
    return (range.a.p_odom_m - first_->a.p_odom_m).norm() +
               (range.b.p_odom_m - first_->b.p_odom_m).norm() >
           kMoved_m;
  }

 private:
  std::optional<JointRange> first_;  ///< first of a run of equal ranges
};

}  // namespace

JointRanges join_ranges(std::span<const VehiclePath> paths, std::optional<Time> since) {
  std::map<Key, Reported> exchanges;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const auto& reported = paths[i].ranges();
    const auto begin =
        since ? std::lower_bound(reported.begin(), reported.end(), *since,
                                 [](const auto& entry, Time t) { return entry->t < t; })
              : reported.begin();
    for (const std::shared_ptr<const RangeEntry>& shared : std::span(begin, reported.end())) {
      const RangeEntry& entry = *shared;
      const auto from = index_of(paths, entry.from);
      const auto to = index_of(paths, entry.to);
      if (!from || !to || from == to) continue;
      Antenna a{*from, entry.from_antenna}, b{*to, entry.to_antenna};
      if (b < a) std::swap(a, b);
      Reported& ends = exchanges[{AntennaPair{a, b}, entry.t}];
      (a.path == i ? ends.by_a : ends.by_b) = &entry;
    }
  }
  JointRanges joint;
  Repetitions repetitions;
  for (const auto& [key, reported] : exchanges) {
    const auto& [pair, t] = key;
    const auto a = end_of(paths[pair.a.path], pair.a.number, t, reported.by_a);
    const auto b = end_of(paths[pair.b.path], pair.b.number, t, reported.by_b);
    if (!a || !b) {
      ++joint.without_pose;
      continue;
    }
    if (joint.pairs.empty() || joint.pairs.back() != pair) joint.pairs.push_back(pair);
    JointRange range;
    range.t = t;
    range.pair = static_cast<int>(joint.pairs.size()) - 1;
    range.a = *a;
    range.b = *b;
    range.range_m = (reported.by_a != nullptr ? reported.by_a : reported.by_b)->range_m;
    // Each end raises sigma by its signal quality and by walls in its map.
    for (const RangeEntry* entry : {reported.by_a, reported.by_b}) {
      if (entry != nullptr) range.sigma_m = std::max(range.sigma_m, entry->sigma_m);
    }
    if (!repetitions.is_one(range)) joint.ranges.push_back(range);
  }
  std::stable_sort(joint.ranges.begin(), joint.ranges.end(),
                   [](const JointRange& x, const JointRange& y) { return x.t < y.t; });
  return joint;
}

}  // namespace rali::fleet
