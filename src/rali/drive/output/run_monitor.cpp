#include "rali/drive/output/run_monitor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "rali/drive/output/map_files.hpp"
#include "rali/drive/output/rounds_files.hpp"
#include "rali/monitor/wall_check.hpp"

namespace rali::drive {
namespace {

using geometry::SE3;
using geometry::Vec3;
using monitor::Contradiction;
using monitor::ContradictionList;
using monitor::SeenThrough;
using monitor::StatedPose;
using monitor::Stretch;

/// A finding about more of a run than this does not help to find the cause.
constexpr double kPartMax_ratio = 0.1;

/// If two estimates contradict each other, either may be wrong: half of the distance is one sigma.
constexpr double kWidenRatio = 0.5;

std::vector<StatedPose> final_track(const VehicleRun& run) {
  const SE3& T_map_local = run.T_map_local();
  std::vector<StatedPose> track;
  track.reserve(run.poses().size());
  for (const PoseRecord& pose : run.poses()) {
    if (pose.quality == vehicle::PoseQuality::kDiverged) continue;
    const geometry::Mat3 P = pose.covariance.bottomRightCorner<3, 3>();
    track.push_back(
        {pose.t, T_map_local * pose.T_local_body, T_map_local.R * P * T_map_local.R.transpose()});
  }
  return track;
}

/// Both frames are level, or neither is: only heading and origin may differ.
SE3 upright(const SE3& T_final_live, const SE3& T_live_first) {
  const Vec3 forward = T_final_live.R * Vec3::UnitX();
  SE3 out;
  out.R = Eigen::AngleAxisd(std::atan2(forward.y(), forward.x()), Vec3::UnitZ()).toRotationMatrix();
  out.p = T_final_live * T_live_first.p - out.R * T_live_first.p;
  return out;
}

std::string from_to(const Stretch& when, Time t_first) {
  return fmt::format("from {:.0f} to {:.0f} s", seconds_between(t_first, when.begin),
                     seconds_between(t_first, when.end));
}

Finding finding_of(const Contradiction& c, const std::string& when, const std::string& what,
                   const char* against) {
  Finding f;
  f.id = "monitor.contradiction";
  f.value = c.off_m;
  f.limit = c.stated_m;
  f.text = fmt::format("{} {} lies up to {:.2f} m off {}, stated {:.2f} m (1 sigma)", when, what,
                       c.off_m, against, c.stated_m);
  f.effect = "one of the two is wrong there; the final error is stated larger";
  return f;
}

std::string text_of(const SeenThrough& s, const std::string& when) {
  const double percent = 100.0 * s.ratio;
  if (s.of_others) {
    return fmt::format("{} its scans look through {:.0f} % of the walls in view that others saw",
                       when, percent);
  }
  return s.looks
             ? fmt::format("{} its scans look through {:.0f} % of the walls in view", when, percent)
             : fmt::format("{} it saw walls of which {:.0f} % are looked through by others", when,
                           percent);
}

Finding finding_of(const SeenThrough& s, const std::string& when, bool of_fleet) {
  Finding f;
  f.id = "monitor.walls";
  f.severity = Severity::kError;
  f.value = s.ratio;
  f.text = text_of(s, when);
  f.effect = "its position relative to the rest of the map is wrong there";
  f.remedy =
      of_fleet
          ? "Look at the map for doubled walls. Check start poses; drive where others have been."
          : "Look at the map for doubled walls. Keep the LiDAR level and its view free; do not "
            "carry the vehicle or take it in a lift while it records.";
  return f;
}

/// Runs the checks and collects their findings.
class RunMonitor {
 public:
  RunMonitor(std::vector<VehicleRun>& runs, const fleet::FleetEstimate& estimate)
      : runs_(runs), estimate_(estimate) {}

  void tracks() {
    for (const std::vector<VehicleId>& group : estimate_.groups) {
      for (const VehicleId id : group) odometry(id);
      live(group);
    }
  }

  void walls(const std::vector<map::KeyframeLooks>& looks);

  [[nodiscard]] MonitorResult take() { return std::move(result_); }

 private:
  static monitor::MonitorSettings in_parts(monitor::MonitorSettings settings,
                                           const VehicleRun& run) {
    settings.part_max_s =
        kPartMax_ratio * seconds_between(run.poses().front().t, run.poses().back().t);
    return settings;
  }

  template <class Found, class... More>
  void add(const VehicleRun& run, const Found& found, const More&... more) {
    Finding f = finding_of(found, from_to(found.when, run.poses().front().t), more...);
    f.vehicle = run.name();
    f.t = found.when.begin;
    f.t_end = found.when.end;
    result_.findings.push_back(std::move(f));
  }

  void odometry(VehicleId id) {
    VehicleRun& run = runs_[id.value];
    if (run.poses().empty()) return;
    const std::vector<StatedPose> reference = final_track(run);
    const SE3 T = monitor::agreeing_at_first(run.odometry_track(), reference);
    report(id, monitor::check_track(run.odometry_track(), reference, T, in_parts(settings_, run)),
           "odometry/", "the final path");
  }

  void live(const std::vector<VehicleId>& group) {
    std::optional<SE3> T_final_live;
    for (const VehicleId id : group) {
      const VehicleRun& run = runs_[id.value];
      if (run.live_track().empty()) continue;
      const std::vector<StatedPose> reference = final_track(run);
      if (!T_final_live) {
        T_final_live = monitor::agreeing_at_first(run.live_track(), reference);
        if (run.map_frame().levelled) {
          T_final_live = upright(*T_final_live, run.live_track().front().T);
        }
      }
      report(id,
             monitor::check_track(run.live_track(), reference, *T_final_live,
                                  in_parts(settings_, run)),
             "live/", "the final map");
    }
  }

  void report(VehicleId id, const ContradictionList& found, const char* folder,
              const char* against) {
    VehicleRun& run = runs_[id.value];
    if (found.empty()) return;
    for (const Contradiction& c : found) {
      add(run, c, folder + run.name(), against);
      run.widen(c.when.begin, c.when.end, kWidenRatio * c.off_m);
    }
    if (std::find(result_.widened.begin(), result_.widened.end(), id) == result_.widened.end()) {
      result_.widened.push_back(id);
    }
  }

  std::vector<VehicleRun>& runs_;
  const fleet::FleetEstimate& estimate_;
  monitor::MonitorSettings settings_;
  MonitorResult result_;
};

void RunMonitor::walls(const std::vector<map::KeyframeLooks>& looks) {
  std::vector<std::vector<monitor::WallSight>> lines_of_sight(runs_.size());
  for (const map::KeyframeLooks& k : looks) {
    lines_of_sight[k.vehicle].push_back({k.t, k.walls.looks, k.walls.passes, k.made.places,
                                         k.made.passed, k.walls.others_looks,
                                         k.walls.others_passes});
  }
  const monitor::MonitorSettings settings = monitor::settings_for(lines_of_sight, settings_);
  bool contradicted = false;
  for (const std::vector<monitor::WallSight>& own : lines_of_sight) {
    result_.tally.keyframes_checked += monitor::judged(own, settings);
    contradicted |= monitor::looks_through(own, settings);
  }
  if (!contradicted) return;
  result_.map_contradicts_itself = true;
  for (std::size_t v = 0; v < runs_.size(); ++v) {
    if (runs_[v].poses().empty()) continue;
    for (const SeenThrough& found :
         monitor::check_walls(lines_of_sight[v], in_parts(settings, runs_[v]))) {
      add(runs_[v], found, runs_.size() > 1);
    }
  }
}

/// Groups besides the mapped one, by their first vehicle.
std::vector<std::vector<const VehicleRun*>> other_groups(const std::vector<VehicleRun>& runs,
                                                         const fleet::FleetEstimate& estimate) {
  const std::vector<const VehicleRun*> mapped = mapped_runs(runs, estimate);
  std::vector<std::vector<const VehicleRun*>> out;
  for (const std::vector<VehicleId>& group : estimate.groups) {
    std::vector<const VehicleRun*> members;
    for (const VehicleId id : group) {
      const VehicleRun* run = &runs[id.value];
      const bool done = std::find(mapped.begin(), mapped.end(), run) != mapped.end();
      if (!done && !run->keyframes().empty()) members.push_back(run);
    }
    if (!members.empty()) out.push_back(std::move(members));
  }
  return out;
}

}  // namespace

Result<MonitorResult> monitor_run(std::vector<VehicleRun>& runs,
                                  const fleet::FleetEstimate& estimate,
                                  const std::vector<map::KeyframeLooks>& looks, const MapJob& job,
                                  Executor& executor) {
  RunMonitor monitor(runs, estimate);
  monitor.walls(looks);
  for (const auto& group : other_groups(runs, estimate)) {
    const auto own = map::look_at_walls(map_stream(group, job), job.map.dynamic, executor);
    if (!own) return tl::make_unexpected(own.error());
    monitor.walls(*own);
  }
  monitor.tracks();
  MonitorResult result = monitor.take();
  for (const VehicleRun& run : runs) result.tally.keyframes += run.keyframes().size();
  result.tally.contradictions = result.findings.size();
  return result;
}

}  // namespace rali::drive
