#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "rali/cli/picture/map_picture.hpp"
#include "rali/io/files/text.hpp"
#include "rali/io/files/tum.hpp"
#include "rali/report/read_run.hpp"
#include "rali/report/thinned_map.hpp"

namespace rali::cli {
namespace {

namespace fs = std::filesystem;

/// With more vehicles the caption gives only their total.
constexpr std::size_t kNamedVehiclesMax = 4;
/// A vehicle that stayed within this distance of its start is at standstill: its path is noise.
constexpr double kStandstill_m = 0.5;

Status read_points(const std::string& out_dir, MapPicture& picture) {
  std::string path = out_dir + "/map.ply";
  if (std::error_code error; !fs::exists(path, error)) path = out_dir + "/map.pcd";
  Result<report::ThinnedMap> map = report::read_thinned_map(path);
  if (!map) return tl::make_unexpected(map.error());
  picture.x_m = std::move(map->points.x_m);
  picture.y_m = std::move(map->points.y_m);
  picture.z_m = std::move(map->points.z_m);
  return {};
}

/// Trajectories in natural order of their names.
std::vector<std::string> trajectory_files(const std::string& out_dir) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(out_dir + "/trajectory", error)) {
    const std::string name = entry.path().filename().string();
    const bool whole = name.ends_with(".tum") && !name.ends_with(".imu.tum");
    if (whole && !name.starts_with('.')) names.push_back(name);
  }
  std::sort(names.begin(), names.end(), io::natural_less);
  return names;
}

double length_m(const std::vector<geometry::Vec3>& points) {
  double sum_m = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) sum_m += (points[i] - points[i - 1]).norm();
  return sum_m;
}

bool stands(const std::vector<geometry::Vec3>& points) {
  return std::all_of(points.begin(), points.end(), [&](const geometry::Vec3& p) {
    return (p - points.front()).norm() < kStandstill_m;
  });
}

/// "v1 stands, v2 travelled 12.3 m".
std::string distances_of(const std::vector<PictureTrajectory>& trajectories) {
  if (trajectories.size() > kNamedVehiclesMax) {
    double sum_m = 0.0;
    for (const PictureTrajectory& t : trajectories) sum_m += length_m(t.points_map_m);
    return fmt::format("{} vehicles travelled {:.0f} m", trajectories.size(), sum_m);
  }
  std::string text;
  for (const PictureTrajectory& t : trajectories) {
    if (!text.empty()) text += ", ";
    text += stands(t.points_map_m)
                ? t.label + " stands"
                : fmt::format("{} travelled {:.1f} m", t.label, length_m(t.points_map_m));
  }
  return text;
}

/// If `rali evaluate` has run: adds the ground truth, and the error in the caption.
Status add_truth(const std::string& out_dir, MapPicture& picture) {
  std::error_code error;
  if (!fs::exists(out_dir + "/evaluation.json", error)) return {};
  const Result<report::RunData> run = report::read_run(out_dir);
  if (!run) return tl::make_unexpected(run.error());
  for (const report::VehicleView& vehicle : run->vehicles) {
    PictureTrajectory truth{"truth", true, {}};
    for (const report::PathPoint& point : vehicle.truth) truth.points_map_m.push_back(point.p_m);
    if (!truth.points_map_m.empty()) picture.trajectories.push_back(std::move(truth));
  }
  for (const report::Measured& measured : run->evaluation) {
    if (measured.key != "fleet.trajectory.ape_m.rmse" || !std::isfinite(measured.value)) continue;
    picture.caption +=
        fmt::format("; error {:.{}f} m (APE rmse)", measured.value, measured.value < 1.0 ? 3 : 1);
  }
  return {};
}

}  // namespace

Result<MapPicture> picture_of_folder(const std::string& out_dir) {
  MapPicture picture;
  picture.name = out_dir;
  if (Status status = read_points(out_dir, picture); !status) {
    return tl::make_unexpected(status.error());
  }
  for (const std::string& name : trajectory_files(out_dir)) {
    const Result<io::TumFile> tum = io::read_tum(out_dir + "/trajectory/" + name);
    if (!tum) return tl::make_unexpected(tum.error());
    PictureTrajectory trajectory;
    trajectory.label = name.substr(0, name.size() - 4);
    for (const io::StampedPose& pose : tum->poses) trajectory.points_map_m.push_back(pose.T.p);
    picture.trajectories.push_back(std::move(trajectory));
  }
  picture.caption = distances_of(picture.trajectories);
  if (Status s = add_truth(out_dir, picture); !s) return tl::make_unexpected(s.error());
  return picture;
}

}  // namespace rali::cli
