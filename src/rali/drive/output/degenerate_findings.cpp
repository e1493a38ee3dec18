#include "rali/drive/output/degenerate_findings.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace rali::drive {
namespace {

constexpr double kReported_m = 0.3;  // smaller sigmas are acceptable to users of a map
constexpr double kGrown_m = 0.1;     // since the start: earlier growth was reported before
constexpr double kGlimpse_s = 2.0;   // a shorter constrained interval ends no stretch
constexpr double kFraction = 0.1;    // of the recording

/// Poses [begin, end] by index.
struct Stretch {
  std::size_t begin = 0, end = 0;
};

bool rests_on_imu(const PoseRecord& pose) {
  return pose.degenerate && (pose.held_by == HeldBy::kImu || pose.held_by == HeldBy::kNothing);
}

std::vector<Stretch> stretches_of(const std::vector<PoseRecord>& poses) {
  std::vector<Stretch> out;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!rests_on_imu(poses[i])) continue;
    const bool goes_on =
        !out.empty() && seconds_between(poses[out.back().end].t, poses[i].t) <= kGlimpse_s;
    if (goes_on) {
      out.back().end = i;
    } else {
      out.push_back({i, i});
    }
  }
  return out;
}

Finding finding_of(const PoseRecord& begin, const PoseRecord& end, Time t_first, double max_m) {
  Finding f;
  f.id = "odometry.degenerate";
  f.severity = Severity::kWarning;
  f.t = begin.t;
  f.t_end = end.t;
  f.text = fmt::format(
      "degenerate along the path from {:.0f} to {:.0f} s, and no range constrained the vehicle: "
      "its position there is known to {:.1f} m (1 sigma)",
      seconds_between(t_first, begin.t), seconds_between(t_first, end.t), max_m);
  f.effect = "the map may be longer or shorter there by as much";
  f.remedy =
      "Let another vehicle stand still in line of sight and measure ranges, or check that ranges "
      "arrive.";
  f.value = max_m;
  f.limit = kReported_m;
  return f;
}

}  // namespace

FindingList degenerate_findings(const std::vector<PoseRecord>& poses, const std::string& vehicle) {
  FindingList out;
  if (poses.empty()) return out;
  const double longest_s = kFraction * seconds_between(poses.front().t, poses.back().t);
  for (const Stretch& stretch : stretches_of(poses)) {
    const double before_m = position_sigma_m(poses[stretch.begin]);
    std::size_t begin = stretch.begin;
    double max_m = 0.0;
    for (std::size_t i = stretch.begin; i <= stretch.end; ++i) {
      max_m = std::max(max_m, position_sigma_m(poses[i]));
      const bool full = seconds_between(poses[begin].t, poses[i].t) >= longest_s;
      if (!full && i < stretch.end) continue;
      if (max_m >= kReported_m && max_m >= before_m + kGrown_m) {
        out.push_back(finding_of(poses[begin], poses[i], poses.front().t, max_m));
        out.back().vehicle = vehicle;
      }
      begin = i;
      max_m = 0.0;
    }
  }
  return out;
}

}  // namespace rali::drive
