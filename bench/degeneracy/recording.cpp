#include "recording.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "place.hpp"
#include "rali/base/rng.hpp"
#include "rali/sim/lidar_sensor.hpp"

namespace rali::degeneracy_bench {

using geometry::SE3;
using geometry::Vec3;

namespace {

constexpr double kStep_s = 0.02;

/// The rest of a route from `from_m` on, for a vehicle that drives ahead.
sim::Route rest_of(const sim::Route& route, double from_m) {
  std::vector<Vec3> corners;
  for (double s = from_m; s < route.length_m(); s += 1.0) corners.push_back(route.point_at(s));
  corners.push_back(route.point_at(route.length_m() + 1.0));
  return {corners, 1.0};
}

/// A stationary vehicle beside the route at a random heading offset.
sim::Trajectory standing_at(const sim::Route& route, double s_m, double left_m,
                            double body_height_m, Rng& rng) {
  const double yaw = route.yaw_at(s_m);
  sim::Trajectory::Control control;
  control << route.point_at(s_m) + Vec3(-left_m * std::sin(yaw), left_m * std::cos(yaw), 0.0), 0.0,
      0.0, yaw + rng.uniform(-0.5, 0.5);
  control[2] += body_height_m;
  return {std::vector<sim::Trajectory::Control>(8, control), 1.0};
}

/// Horizontal direction of the route at its point nearest to p, searched from s_m, which is
/// advanced.
Vec3 axis_at(const sim::Route& route, const Vec3& p, double& s_m) {
  double best = (route.point_at(s_m) - p).norm();
  for (double s = s_m; s < s_m + 3.0 && s < route.length_m(); s += 0.1) {
    const double d = (route.point_at(s) - p).norm();
    if (d >= best) continue;
    best = d;
    s_m = s;
  }
  const double yaw = route.yaw_at(s_m);
  return {std::cos(yaw), std::sin(yaw), 0.0};
}

sim::Crowd crowd_of(const DriveOptions& options) {
  sim::SimOptions all;
  all.pedestrians = options.pedestrians;
  return sim::crowd_of(all);
}

/// Everything that is constant during one drive.
struct Drive {
  Drive(const DriveOptions& o, sim::World place)
      : world(std::move(place)),
        route(world.route, world.rounding_m),
        trajectory(sim::make_trajectory(route, motion, o.seed)),
        caster(world.mesh),
        scene(sim::Pedestrians(route, crowd_of(o), world.free_width_m, o.seed)),
        ranging(sim::LidarOptions::of(o.lidar)),
        lidar(o.lidar, ranging, o.seed) {}

  sim::MotionOptions motion;
  sim::World world;
  sim::Route route;
  sim::Trajectory trajectory;
  sim::RayCaster caster;
  sim::MovingScene scene;
  sim::LidarOptions ranging;
  sim::LidarSensor lidar;
  std::optional<sim::Trajectory> other;
  SerialExecutor serial;
};

void add_other(Drive& d, const DriveOptions& o, double from_m, Rng& rng) {
  if (o.other == Other::kNobody) return;
  if (o.other == Other::kAhead) {
    const sim::Route ahead = rest_of(d.route, rng.uniform(6.0, 16.0));
    d.other = sim::make_trajectory(ahead, d.motion, o.seed + 1000);
  } else {
    const double s = from_m + o.path_m * rng.uniform(0.5, 0.9);
    const double left = std::min(1.0, d.world.free_width_m) * (rng.uniform() < 0.5 ? -1.0 : 1.0);
    d.other = standing_at(d.route, s, left, d.motion.body_height_m, rng);
  }
  d.scene.add_vehicle(sim::VehicleLook{}, *d.other);
}

Station measure(Drive& d, double t_end_s, const SE3& T_body_lidar) {
  const double scan_s = d.lidar.model().scan_s();
  const double start_s = t_end_s - scan_s;
  const auto number = static_cast<std::int64_t>(std::lround(start_s / scan_s));
  const auto pose_at = [&](double t_s) { return d.trajectory.pose_at(t_s) * T_body_lidar; };
  const sim::RawScan& raw =
      d.lidar.measure_scan(number, start_s, pose_at, d.caster, d.scene, d.serial);
  const Time t_start = Time::from_ns(0) + Duration::from_s(start_s);
  Station out;
  out.scan = sim::expand(raw, d.lidar.model(), d.ranging.resolution_m, t_start);
  constexpr int kPoses = 10;
  for (int k = 0; k <= kPoses; ++k) {
    const double t_s = start_s + scan_s * k / kPoses;
    out.poses.push_back({Time::from_ns(0) + Duration::from_s(t_s), d.trajectory.pose_at(t_s)});
  }
  out.T_world_body = out.poses.back().T_odom_body;
  if (d.other) out.others_world_m.push_back(d.other->pose_at(start_s + 0.5 * scan_s).p);
  return out;
}

}  // namespace

Status drive(const DriveOptions& o, const StationListener& listener) {
  sim::SimOptions checked;
  checked.pedestrians = o.pedestrians;
  if (auto ok = sim::check_options(checked); !ok) return ok;
  auto place = make_place(o.place, o.seed);
  if (!place) return tl::make_unexpected(place.error());
  Drive d(o, std::move(*place));
  Rng rng(o.seed, "drive");
  const double spare_m = std::max(0.0, d.route.length_m() - o.path_m - 1.0);
  const double from_m = rng.uniform(0.0, spare_m);
  add_other(d, o, from_m, rng);
  const SE3 T_body_lidar = sim::sensor_mounting(false).T_body_lidar;
  const sensor::Calibration calibration = sim::sensor_mounting(false);

  double path_m = 0.0;
  // Moving objects leave a trail in the map; it is as dense as in operation only with every scan.
  const double station_m = o.other == Other::kAhead ? 0.125 : 0.5;
  double next_m = from_m;
  double route_s_m = 0.0;
  Vec3 before = d.trajectory.pose_at(0.0).p;
  for (double t_s = kStep_s; t_s < d.trajectory.duration_s(); t_s += kStep_s) {
    const Vec3 p = d.trajectory.pose_at(t_s).p;
    path_m += (p - before).head<2>().norm();
    before = p;
    if (path_m > from_m + o.path_m) break;
    if (path_m < next_m || t_s < d.lidar.model().scan_s()) continue;
    next_m += station_m;
    Station station = measure(d, t_s, T_body_lidar);
    station.axis_world = axis_at(d.route, p, route_s_m);
    station.driven_m = path_m - from_m;
    listener(station, calibration);
  }
  return {};
}

}  // namespace rali::degeneracy_bench
