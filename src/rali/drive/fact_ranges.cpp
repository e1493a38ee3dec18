#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "rali/drive/fact_path.hpp"
#include "rali/drive/output/final_path.hpp"

namespace rali::drive {
namespace {

using fleet::RangeEntry;
using ranging::RangeReason;
using ranging::RangeUse;

/// A residual beyond this many sigmas contradicts the map.
constexpr double kSigmas = 3.0;

/// Each measurement once, whichever of its ends reported it, by time. If both did, the larger sigma
/// is used.
std::vector<RangeEntry> distinct_ranges(const FleetFacts& facts) {
  using Key = std::tuple<Time, VehicleId, VehicleId, std::uint8_t, std::uint8_t>;
  std::map<Key, RangeEntry> ranges;
  for (const FleetFacts::Member& member : facts.members) {
    for (const fleet::FactPtr& fact : member.facts) {
      const auto* block = std::get_if<fleet::RangeBlock>(&fact->body);
      if (block == nullptr) continue;
      for (const RangeEntry& r : block->ranges) {
        const Key key{r.t, r.from, r.to, r.from_antenna, r.to_antenna};
        const auto [known, added] = ranges.emplace(key, r);
        if (!added) known->second.sigma_m = std::max(known->second.sigma_m, r.sigma_m);
      }
    }
  }
  std::vector<RangeEntry> out;
  for (auto& [key, range] : ranges) out.push_back(std::move(range));
  return out;
}

/// Judges ranges by the final poses.
class RangeJudge {
 public:
  RangeJudge(const FleetFacts& facts, const std::vector<VehicleRun>& runs,
             const fleet::FleetEstimate& estimate)
      : facts_(facts), estimate_(estimate), group_(runs.size(), runs.size()) {
    for (const VehicleRun& run : runs) paths_.emplace_back(run.poses(), run.T_map_local());
    for (std::size_t g = 0; g < estimate.groups.size(); ++g) {
      for (const VehicleId id : estimate.groups[g]) group_[id.value] = g;
    }
    for (const fleet::UsedRange& used : estimate.ranges) {
      used_.insert({used.t, std::minmax(used.a.vehicle, used.b.vehicle)});
    }
  }

  [[nodiscard]] RangeUse use_of(const RangeEntry& range) const {
    RangeUse use;
    use.sample = sample_of(range);
    use.sigma_m = range.sigma_m;
    const auto from = antenna_at(range.from, range.from_antenna, range.t);
    const auto to = antenna_at(range.to, range.to_antenna, range.t);
    const bool joined = from && to && group_[range.from.value] == group_[range.to.value];
    if (!joined) return use;  // no pose
    use.bias_m = bias_of(range);
    use.predicted_m = (*from - *to).norm() + use.bias_m;
    use.residual_m = range.range_m - use.predicted_m;
    const bool fits = std::abs(use.residual_m) <= kSigmas * range.sigma_m;
    const bool used = used_.contains({range.t, std::minmax(range.from, range.to)});
    use.reason = used ? RangeReason::kUsed : fits ? RangeReason::kNotNeeded : RangeReason::kOutlier;
    return use;
  }

  static sensor::RangeSample sample_of(const RangeEntry& range) {
    sensor::RangeSample sample;
    sample.t = range.t;
    sample.from = range.from;
    sample.to = range.to;
    sample.from_antenna = range.from_antenna;
    sample.to_antenna = range.to_antenna;
    sample.range_m = range.range_m;
    return sample;
  }

 private:
  [[nodiscard]] std::optional<geometry::Vec3> antenna_at(VehicleId id, std::uint8_t antenna,
                                                         Time t) const {
    if (id.value >= paths_.size()) return std::nullopt;
    const auto& antennas = facts_.members[id.value].antennas_body_m;
    const auto T_map_body = paths_[id.value].at(t);
    if (!T_map_body || antenna >= antennas.size()) return std::nullopt;
    return *T_map_body * antennas[antenna];
  }

  [[nodiscard]] double bias_of(const RangeEntry& range) const {
    for (const fleet::PairBias& bias : estimate_.biases) {
      const bool along = bias.a == range.from && bias.b == range.to &&
                         bias.antenna_a == range.from_antenna && bias.antenna_b == range.to_antenna;
      const bool back = bias.a == range.to && bias.b == range.from &&
                        bias.antenna_a == range.to_antenna && bias.antenna_b == range.from_antenna;
      if (along || back) return bias.bias_m;
    }
    return 0.0;
  }

  const FleetFacts& facts_;
  const fleet::FleetEstimate& estimate_;
  std::vector<std::size_t> group_;  ///< of each vehicle
  std::vector<FinalPath> paths_;
  std::set<std::pair<Time, std::pair<VehicleId, VehicleId>>> used_;
};

}  // namespace

void log_fact_ranges(const FleetFacts& facts, const std::vector<VehicleRun>& runs,
                     const fleet::FleetEstimate& estimate, RangeLog& log) {
  const std::vector<RangeEntry> ranges = distinct_ranges(facts);
  for (const RangeEntry& range : ranges) log.add_handed(RangeJudge::sample_of(range));
  const RangeJudge judge(facts, runs, estimate);
  for (const RangeEntry& range : ranges) log.answer(judge.use_of(range), range.from, true);
}

}  // namespace rali::drive
