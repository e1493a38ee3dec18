#include "rali/eval/association.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace rali::eval {

using geometry::SE3;

namespace {

// Stamps of 5 Hz ground truth written with few decimals are 0.2000001 s apart.
constexpr double kGapSlack_s = 1e-6;

Status check_order(const PoseList& list, const char* name) {
  for (std::size_t i = 1; i < list.size(); ++i) {
    if (list[i].t <= list[i - 1].t) {
      return fail(
          ErrorCode::kInput, fmt::format("{} trajectory, pose {}", name, i + 1),
          fmt::format("time {:.9f} s does not follow {:.9f} s", list[i].t.s(), list[i - 1].t.s()),
          "Sort the poses by time and remove doubles.");
    }
  }
  return {};
}

PoseList::const_iterator first_not_before(const PoseList& list, Time t) {
  return std::lower_bound(list.begin(), list.end(), t,
                          [](const StampedPose& p, Time time) { return p.t < time; });
}

/// Index of the pose nearest in time, the earlier one of two; empty beyond max_dt_s.
std::optional<std::size_t> nearest(const PoseList& list, Time t, double max_dt_s) {
  const auto after = first_not_before(list, t);
  auto best = after == list.end() ? after - 1 : after;
  if (after != list.begin() && after != list.end() && t - (after - 1)->t <= after->t - t) {
    best = after - 1;
  }
  if (std::abs(seconds_between(best->t, t)) > max_dt_s) return std::nullopt;
  return static_cast<std::size_t>(best - list.begin());
}

/// As evo, pairs from the list with fewer poses (the estimate, if equal) to the longer one; a pose
/// of the longer list may be used twice.
void pair_nearest(const PoseList& est, const PoseList& ref, double max_dt_s, PairList& pairs) {
  const bool from_ref = est.size() > ref.size();
  const PoseList& from = from_ref ? ref : est;
  const PoseList& to = from_ref ? est : ref;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const auto j = nearest(to, from[i].t, max_dt_s);
    if (!j) continue;
    const std::size_t e = from_ref ? *j : i;
    const std::size_t r = from_ref ? i : *j;
    pairs.push_back({est[e].t, est[e].T, ref[r].T, e});
  }
}

}  // namespace

std::optional<SE3> pose_at(const PoseList& list, Time t, double max_gap_s) {
  const auto after = first_not_before(list, t);
  if (after == list.end()) return std::nullopt;
  if (after->t == t) return after->T;
  if (after == list.begin()) return std::nullopt;
  const auto before = after - 1;
  const double gap_s = seconds_between(before->t, after->t);
  if (gap_s > max_gap_s + kGapSlack_s) return std::nullopt;
  return geometry::interpolate(before->T, after->T, seconds_between(before->t, t) / gap_s);
}

Result<Association> associate(const PoseList& est, const PoseList& ref,
                              const AssociationOptions& options) {
  if (auto ok = check_order(est, "estimated"); !ok) return tl::make_unexpected(ok.error());
  if (auto ok = check_order(ref, "reference"); !ok) return tl::make_unexpected(ok.error());
  Association out;
  std::size_t asked = est.size();
  if (!ref.empty() && !est.empty()) {
    if (options.mode == AssociationMode::kNearest) {
      asked = std::min(est.size(), ref.size());
      pair_nearest(est, ref, options.max_dt_s, out.pairs);
    } else {
      for (std::size_t i = 0; i < est.size(); ++i) {
        const auto T = pose_at(ref, est[i].t, options.max_gap_s);
        if (T) out.pairs.push_back({est[i].t, est[i].T, *T, i});
      }
    }
  }
  out.unmatched = asked - out.pairs.size();
  if (out.pairs.empty()) {
    return fail(ErrorCode::kNoAnswer, {},
                fmt::format("none of {} estimated and {} reference poses belong together in time",
                            est.size(), ref.size()),
                "Check that both use the same clock.");
  }
  return out;
}

}  // namespace rali::eval
