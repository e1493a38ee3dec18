#include "rali/drive/output/final_path.hpp"

#include <algorithm>

namespace rali::drive {
namespace {

constexpr double kGap_s = 1.0;

bool is_good(const PoseRecord& pose) { return pose.quality != vehicle::PoseQuality::kDiverged; }

std::vector<PoseRecord>::const_iterator first_after(const std::vector<PoseRecord>& poses, Time t) {
  return std::upper_bound(poses.begin(), poses.end(), t,
                          [](Time at, const PoseRecord& pose) { return at < pose.t; });
}

}  // namespace

std::optional<geometry::SE3> FinalPath::at(Time t) const {
  const auto after = first_after(*poses_, t);
  if (after == poses_->begin()) return std::nullopt;
  const PoseRecord& a = *std::prev(after);
  if (!is_good(a)) return std::nullopt;
  if (a.t == t) return T_map_local_ * a.T_local_body;
  if (after == poses_->end() || !is_good(*after)) return std::nullopt;
  const double span_s = seconds_between(a.t, after->t);
  if (span_s > kGap_s && !after->tied) return std::nullopt;
  const double fraction = seconds_between(a.t, t) / span_s;
  return T_map_local_ * geometry::interpolate(a.T_local_body, after->T_local_body, fraction);
}

const PoseRecord* FinalPath::before(Time t) const {
  const auto after = first_after(*poses_, t);
  return after == poses_->begin() ? nullptr : &*std::prev(after);
}

std::optional<geometry::SE3> FinalPath::last_known(Time t) const {
  for (auto at = first_after(*poses_, t); at != poses_->begin();) {
    --at;
    if (is_good(*at)) return T_map_local_ * at->T_local_body;
  }
  return std::nullopt;
}

}  // namespace rali::drive
