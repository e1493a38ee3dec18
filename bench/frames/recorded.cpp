#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "drive.hpp"
#include "parts.hpp"
#include "pyfg.hpp"
#include "rali/fleet/frames/frame_solver.hpp"
#include "rali/geometry/so3.hpp"

namespace rali::frames_bench {

using fleet::kDegree;
using fleet::YawPose;
using geometry::Mat3;
using geometry::SE3;
using geometry::Vec3;
using ranges_bench::Pyfg;
using ranges_bench::PyfgName;

namespace {

constexpr double kEvery_s = 2.0;

/// Odometry of one robot in its gravity-aligned odom frame, the frame of its first pose.
struct Robot {
  fleet::StreamKey key;
  YawPose T_world_odom;  ///< true
  std::map<int, SE3> T_odom_body;
  std::map<int, Mat3> covariance_m2;  ///< of the position, without the effect of heading errors
  double path_m = 0.0, yaw_variance = 0.0;
};

struct Recording {
  std::vector<Robot> robots;
  std::map<char, std::size_t> index;
  std::vector<ranges_bench::PyfgRange> ranges;  ///< between robots, by time
};

void start_robot(const Pyfg& file, const PyfgName& name, Recording& out) {
  const SE3 T_world_first = file.poses.at(name).T;
  Robot robot;
  robot.key = {VehicleId{static_cast<std::uint16_t>(name.robot - 'A')}, 0};
  // Gravity determines roll and pitch; heading and position are to be estimated.
  const Vec3 rpy = geometry::rpy_from_rotation(T_world_first.R);
  robot.T_world_odom = {rpy.z(), T_world_first.p};
  robot.T_odom_body[name.index] = {geometry::rotation_from_rpy(rpy.x(), rpy.y(), 0.0),
                                   Vec3::Zero()};
  robot.covariance_m2[name.index] = Mat3::Zero();
  out.index[name.robot] = out.robots.size();
  out.robots.push_back(std::move(robot));
}

Recording recording_of(const Pyfg& file) {
  Recording out;
  for (const auto& [name, pose] : file.poses) {
    if (!out.index.contains(name.robot)) start_robot(file, name, out);
  }
  for (const ranges_bench::PyfgStep& step : file.steps) {
    if (step.from.robot != step.to.robot) continue;
    Robot& robot = out.robots[out.index.at(step.from.robot)];
    const auto before = robot.T_odom_body.find(step.from.index);
    if (before == robot.T_odom_body.end()) continue;
    const SE3 T = before->second * step.T_from_to;
    const Mat3 R = before->second.R;
    robot.T_odom_body[step.to.index] = T;
    robot.covariance_m2[step.to.index] =
        robot.covariance_m2[step.from.index] +
        R * step.covariance.bottomRightCorner<3, 3>() * R.transpose();
    robot.path_m += step.T_from_to.p.norm();
    robot.yaw_variance += step.covariance(2, 2);
  }
  for (const ranges_bench::PyfgRange& r : file.ranges) {
    const bool both = out.index.contains(r.from.robot) && out.index.contains(r.to.robot);
    if (both && r.from.robot != r.to.robot) out.ranges.push_back(r);
  }
  std::stable_sort(out.ranges.begin(), out.ranges.end(),
                   [](const auto& a, const auto& b) { return a.t < b.t; });
  return out;
}

/// Drift settings from the covariances in the files.
fleet::InitSettings settings_of(const Recording& recording) {
  fleet::InitSettings settings;
  double walk = 0.0;
  for (const Robot& robot : recording.robots) {
    if (robot.path_m > 1.0) walk = std::max(walk, std::sqrt(robot.yaw_variance / robot.path_m));
  }
  settings.drift.yaw_deg_per_sqrt_m = std::max(settings.drift.yaw_deg_per_sqrt_m, walk / kDegree);
  return settings;
}

class Run {
 public:
  explicit Run(const Recording& recording)
      : recording_(recording),
        settings_(settings_of(recording)),
        solver_(settings_, recording.robots.front().key) {
    for (const Robot& robot : recording.robots) {
      solver_.add_vehicle(robot.key);
      names_[robot.key.vehicle] = std::string(1, static_cast<char>('A' + robot.key.vehicle.value));
    }
  }

  std::string rows(const std::string& name) {
    const Time begin = recording_.ranges.front().t;
    Time next = begin;
    for (const ranges_bench::PyfgRange& r : recording_.ranges) {
      add(r);
      if (r.t < next) continue;
      next = r.t + Duration::from_s(kEvery_s);
      solver_.evaluate(r.t);
      note((r.t - begin).s());
    }
    std::string out;
    for (std::size_t v = 1; v < recording_.robots.size(); ++v) out += row(name, v);
    return out;
  }

 private:
  void add(const ranges_bench::PyfgRange& r) {
    const Robot& a = recording_.robots[recording_.index.at(r.from.robot)];
    const Robot& b = recording_.robots[recording_.index.at(r.to.robot)];
    const auto at_a = a.T_odom_body.find(r.from.index);
    const auto at_b = b.T_odom_body.find(r.to.index);
    if (at_a == a.T_odom_body.end() || at_b == b.T_odom_body.end()) return;
    fleet::RangeObservation o;
    o.t = r.t;
    o.x_a_m = at_a->second.p;
    o.y_b_m = at_b->second.p;
    o.x_covariance_m2 = a.covariance_m2.at(r.from.index);
    o.y_covariance_m2 = b.covariance_m2.at(r.to.index);
    o.range_m = r.range_m;
    o.sigma_m = std::sqrt(r.variance_m2);
    solver_.add_range(a.key, b.key, o);
  }

  struct Error {
    double t_s = 0.0, place_m = 0.0, yaw_deg = 0.0;
  };

  [[nodiscard]] Error error(std::size_t v, const YawPose& T, double t_s) const {
    const YawPose truth =
        recording_.robots.front().T_world_odom.inverse() * recording_.robots[v].T_world_odom;
    return {t_s, (T.t_m - truth.t_m).head<2>().norm(),
            std::abs(fleet::wrapped(T.yaw_rad - truth.yaw_rad)) / kDegree};
  }

  void note(double t_s) {
    for (std::size_t v = 1; v < recording_.robots.size(); ++v) {
      const auto T = solver_.T_ref_odom(recording_.robots[v].key);
      if (!T) continue;
      committed_.try_emplace(v, error(v, *T, t_s));
      last_[v] = error(v, *T, t_s);
    }
  }

  [[nodiscard]] std::string row(const std::string& name, std::size_t v) const {
    const std::string text = solver_.text(recording_.robots[v].key, names_);
    const auto at = committed_.find(v);
    if (at == committed_.end()) {
      return fmt::format("| {} | {} | - | - | - | {} |\n", name, names_.at(key(v)), text);
    }
    const Error& end = last_.at(v);
    return fmt::format("| {} | {} | {:.0f} | {:.2f}, {:.1f} | {:.2f}, {:.1f} | {} |\n", name,
                       names_.at(key(v)), at->second.t_s, at->second.place_m, at->second.yaw_deg,
                       end.place_m, end.yaw_deg, text);
  }

  [[nodiscard]] VehicleId key(std::size_t v) const { return recording_.robots[v].key.vehicle; }

  const Recording& recording_;
  fleet::InitSettings settings_;
  fleet::FrameSolver solver_;
  fleet::VehicleNames names_;
  std::map<std::size_t, Error> committed_, last_;
};

}  // namespace

Result<std::string> recorded_table(const std::filesystem::path& folder) {
  std::string out =
      "Start frames unknown; odometry and ranges between robots only. Errors in the plane, of the "
      "frame at the robot's first pose.\n\n"
      "| set | robot | committed at s | error then: m, deg | error at the end: m, deg | in words "
      "|\n"
      "|---|---|---|---|---|---|\n";
  for (const char* name : {"tiers", "mrclam3b", "mrclam5a"}) {
    const auto file = ranges_bench::read_pyfg(folder / fmt::format("{}.pyfg", name));
    if (!file) return tl::make_unexpected(file.error());
    const Recording recording = recording_of(*file);
    if (recording.robots.size() < 2 || recording.ranges.empty()) {
      return fail(ErrorCode::kInput, name, "there are no ranges between robots in it");
    }
    out += Run(recording).rows(name);
  }
  return out;
}

}  // namespace rali::frames_bench
