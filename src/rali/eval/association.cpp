#include "rali/eval/association.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

namespace rali::eval {

using geometry::SE3;

namespace {

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

std::optional<SE3> reference_at(const PoseList& ref, Time t, const AssociationOptions& o) {
  const auto after = std::lower_bound(ref.begin(), ref.end(), t,
                                      [](const StampedPose& p, Time time) { return p.t < time; });
  const bool has_after = after != ref.end();
  const bool has_before = after != ref.begin();
  if (has_after && after->t == t) return after->T;
  if (o.mode == AssociationMode::kInterpolate) {
    if (!has_after || !has_before) return std::nullopt;
    const auto before = after - 1;
    const double gap_s = seconds_between(before->t, after->t);
    if (gap_s > o.max_gap_s) return std::nullopt;
    return geometry::interpolate(before->T, after->T, seconds_between(before->t, t) / gap_s);
  }
  auto nearest = has_after ? after : after - 1;
  if (has_before && has_after && t - (after - 1)->t <= after->t - t) nearest = after - 1;
  if (std::abs(seconds_between(nearest->t, t)) > o.max_dt_s) return std::nullopt;
  return nearest->T;
}

}  // namespace

Result<Association> associate(const PoseList& est, const PoseList& ref,
                              const AssociationOptions& options) {
  if (auto ok = check_order(est, "estimated"); !ok) return tl::make_unexpected(ok.error());
  if (auto ok = check_order(ref, "reference"); !ok) return tl::make_unexpected(ok.error());
  Association out;
  if (!ref.empty()) {
    for (std::size_t i = 0; i < est.size(); ++i) {
      if (const auto T = reference_at(ref, est[i].t, options)) {
        out.pairs.push_back({est[i].t, est[i].T, *T, i});
      }
    }
  }
  out.unmatched = est.size() - out.pairs.size();
  if (out.pairs.empty()) {
    return fail(ErrorCode::kNoAnswer, {},
                fmt::format("none of {} estimated and {} reference poses belong together in time",
                            est.size(), ref.size()),
                "Check that both use the same clock.");
  }
  return out;
}

}  // namespace rali::eval
