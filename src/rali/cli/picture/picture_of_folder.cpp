#include <algorithm>
#include <array>
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

constexpr std::array<Colour, 4> kWayColours = {
    {{224, 24, 108}, {250, 120, 0}, {120, 40, 200}, {0, 120, 215}}};

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

/// Trajectories in the order of their names as people count.
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

constexpr Colour kTruthColour{150, 156, 166};
constexpr double kTruthWidth = 11.0;

/// Where `rali evaluate` has judged the run: the truth under the ways, and how far off they are.
Status add_truth(const std::string& out_dir, MapPicture& picture) {
  std::error_code error;
  if (!fs::exists(out_dir + "/evaluation.json", error)) return {};
  const Result<report::RunData> run = report::read_run(out_dir);
  if (!run) return tl::make_unexpected(run.error());
  std::vector<PictureWay> truths;
  for (const report::VehicleView& vehicle : run->vehicles) {
    PictureWay way{truths.empty() ? "truth" : "", kTruthColour, kTruthWidth, {}};
    for (const report::WayPoint& point : vehicle.truth) way.points_map_m.push_back(point.p_m);
    if (!way.points_map_m.empty()) truths.push_back(std::move(way));
  }
  picture.ways.insert(picture.ways.begin(), truths.begin(), truths.end());
  for (const report::Measured& measured : run->evaluation) {
    if (measured.key != "fleet.trajectory.ape_m.rmse") continue;
    picture.subtitle += fmt::format(", off the truth by {:.3f} m (rmse)", measured.value);
  }
  return {};
}

}  // namespace

Result<MapPicture> picture_of_folder(const std::string& out_dir) {
  MapPicture picture;
  picture.title = "RaLI map from above";
  if (Status status = read_points(out_dir, picture); !status) {
    return tl::make_unexpected(status.error());
  }
  std::string ways;
  for (const std::string& name : trajectory_files(out_dir)) {
    const Result<io::TumFile> tum = io::read_tum(out_dir + "/trajectory/" + name);
    if (!tum) return tl::make_unexpected(tum.error());
    PictureWay way;
    way.label = name.substr(0, name.size() - 4);
    way.colour = kWayColours[picture.ways.size() % kWayColours.size()];
    for (const io::StampedPose& pose : tum->poses) way.points_map_m.push_back(pose.T.p);
    ways += fmt::format(", {}: {:.1f} m in {} scans", way.label, length_m(way.points_map_m),
                        way.points_map_m.size());
    picture.ways.push_back(std::move(way));
  }
  picture.subtitle = fmt::format("{} points{}", picture.x_m.size(), ways);
  if (Status s = add_truth(out_dir, picture); !s) return tl::make_unexpected(s.error());
  return picture;
}

}  // namespace rali::cli
