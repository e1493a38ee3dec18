#include "rali/assess/input.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "rali/assess/run_tables.hpp"
#include "rali/io/files/text.hpp"
#include "rali/io/files/tum.hpp"

namespace rali::assess {
namespace {

namespace fs = std::filesystem;

/// Names of the `.tum` files of a folder without extension, in natural order.
std::vector<std::string> tum_names(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  fs::directory_iterator it(folder, error);
  for (; !error && it != fs::directory_iterator(); it.increment(error)) {
    const std::string name = it->path().filename().string();
    // trajectory/<v>.imu.tum holds the same trajectory at the rate of the IMU.
    if (name.starts_with('.') || !name.ends_with(".tum") || name.ends_with(".imu.tum")) continue;
    names.push_back(name.substr(0, name.size() - 4));
  }
  std::sort(names.begin(), names.end(), io::natural_less);
  return names;
}

bool exists(const std::string& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

/// @param levelled  receives the header's statement about its frame; nullptr: not needed
Result<eval::PoseList> read_poses(const std::string& path, std::vector<std::string>& warnings,
                                  std::optional<bool>* levelled = nullptr) {
  const Result<io::TumFile> tum = io::read_tum(path);
  if (!tum) return tl::make_unexpected(tum.error());
  if (levelled != nullptr) *levelled = io::is_levelled(tum->header);
  eval::PoseList poses;
  poses.reserve(tum->poses.size());
  for (const io::StampedPose& pose : tum->poses) poses.push_back({pose.t, pose.T});
  for (const Finding& finding : tum->findings) {
    if (finding.id == "tum.order") {
      return fail(ErrorCode::kInput, "", finding.text,
                  "Sort the lines by time and remove doubles.");
    }
    warnings.push_back(finding.text);
  }
  return poses;
}

Status read_track(const std::string& stem, Track& track, std::vector<std::string>& warnings,
                  std::optional<bool>* levelled = nullptr) {
  Result<eval::PoseList> poses = read_poses(stem + ".tum", warnings, levelled);
  if (!poses) return tl::make_unexpected(poses.error());
  track.poses = std::move(*poses);
  if (!exists(stem + ".cov.csv")) return {};
  auto covariances = read_covariances(stem + ".cov.csv", track.poses);
  if (!covariances) return tl::make_unexpected(covariances.error());
  track.covariances = std::move(*covariances);
  return {};
}

/// Whether a file of poses exists and is not empty. A vehicle has no live pose if it was never
/// joined, or if its run ended before gravity was estimated.
bool has_poses(const std::string& path) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (!line.empty() && line.front() != '#') return true;
  }
  return false;
}

/// @param final_poses  folder of the poses that are evaluated first
Status read_vehicle(const std::string& out, const std::string& final_poses, VehicleInput& vehicle,
                    std::vector<std::string>& warnings) {
  const std::string stem = out + '/' + final_poses + '/' + vehicle.name;
  vehicle.file = stem + ".tum";
  if (Status s = read_track(stem, vehicle.trajectory, warnings, &vehicle.levelled); !s) return s;
  for (const auto& [folder, track] :
       {std::pair{"/live/", &vehicle.live}, std::pair{"/odometry/", &vehicle.odometry}}) {
    const std::string path = out + folder + vehicle.name;
    if (path == stem || !has_poses(path + ".tum")) continue;
    if (Status s = read_track(path, *track, warnings); !s) return s;
  }
  const std::string degenerate = out + "/degeneracy/" + vehicle.name + ".csv";
  if (!exists(degenerate)) return {};
  auto directions = read_degenerate_directions(degenerate, vehicle.trajectory.poses);
  if (!directions) return tl::make_unexpected(directions.error());
  vehicle.degenerate_map = std::move(*directions);
  return {};
}

/// Groups of metrics.json in its order; vehicles missing there join the first group, as in runs
/// of other programs, which have only one frame.
std::vector<std::vector<std::size_t>> read_groups(const nlohmann::json& json,
                                                  const std::vector<VehicleInput>& vehicles) {
  std::vector<std::vector<std::size_t>> groups;
  std::vector<bool> placed(vehicles.size(), false);
  const auto pointer = nlohmann::json::json_pointer("/fleet/groups");
  if (json.is_object() && json.contains(pointer) && json[pointer].is_array()) {
    for (const auto& names : json[pointer]) {
      groups.emplace_back();
      if (!names.is_array()) continue;
      for (const auto& name : names) {
        for (std::size_t i = 0; i < vehicles.size(); ++i) {
          if (placed[i] || name != vehicles[i].name) continue;
          placed[i] = true;
          groups.back().push_back(i);
        }
      }
    }
  }
  std::erase_if(groups, [](const auto& group) { return group.empty(); });
  if (groups.empty()) groups.emplace_back();
  for (std::size_t i = 0; i < vehicles.size(); ++i) {
    if (!placed[i]) groups.front().push_back(i);
  }
  std::stable_sort(groups.begin(), groups.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return groups;
}

void read_time_offsets(const nlohmann::json& json, std::vector<VehicleInput>& vehicles) {
  for (VehicleInput& vehicle : vehicles) {
    const nlohmann::json::json_pointer pointer =
        nlohmann::json::json_pointer("/vehicles") / vehicle.name / "time_offset_s";
    if (!json.is_object() || !json.contains(pointer) || !json[pointer].is_number()) continue;
    vehicle.time_offset_s = json[pointer].get<double>();
  }
}

Result<RunInput> read_out_folder(const std::string& path) {
  RunInput run;
  run.name = path;
  run.out_folder = true;
  // rali run --poses writes only live poses.
  std::string final_poses = "trajectory";
  std::vector<std::string> names = tum_names(path + "/trajectory");
  if (names.empty()) {
    final_poses = "live";
    names = tum_names(path + "/live");
    std::erase_if(names,
                  [&](const std::string& v) { return !has_poses(path + "/live/" + v + ".tum"); });
  }
  for (const std::string& name : names) {
    VehicleInput vehicle;
    vehicle.name = name;
    if (Status s = read_vehicle(path, final_poses, vehicle, run.warnings); !s) {
      return tl::make_unexpected(s.error());
    }
    run.vehicles.push_back(std::move(vehicle));
  }
  for (const char* name : {"/map.pcd", "/map.ply"}) {
    if (run.cloud.empty() && exists(path + name)) run.cloud = path + name;
  }
  if (run.vehicles.empty() && run.cloud.empty()) {
    return fail(ErrorCode::kInput, path, "has no poses in trajectory/ or live/, and no map.pcd",
                "Give the folder that rali map or rali run --poses has written.");
  }
  std::ifstream file(path + "/metrics.json");
  const nlohmann::json metrics = nlohmann::json::parse(file, nullptr, false);
  run.groups = read_groups(metrics, run.vehicles);
  read_time_offsets(metrics, run.vehicles);
  return run;
}

bool is_cloud_name(const std::string& path) {
  const std::string extension = io::lower_case(fs::path(path).extension().string());
  return extension == ".pcd" || extension == ".ply" || extension == ".bin";
}

void carry_to_body(const geometry::SE3& T_body_truth, eval::PoseList& truth) {
  const geometry::SE3 T_truth_body = T_body_truth.inverse();
  for (eval::StampedPose& pose : truth) pose.T = pose.T * T_truth_body;
}

Status no_truth(const std::string& path, const RunInput& run,
                const std::vector<std::string>& there) {
  std::vector<std::string> wanted;
  for (const VehicleInput& v : run.vehicles) wanted.push_back(v.name + ".tum");
  return fail(ErrorCode::kInput, path,
              fmt::format("has no truth of any vehicle ({}); it has {}", fmt::join(wanted, ", "),
                          there.empty() ? "no .tum file"
                                        : fmt::format("{}.tum", fmt::join(there, ".tum, "))),
              "Name the files after the vehicles.");
}

}  // namespace

Result<RunInput> read_run(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) return fail(ErrorCode::kInput, path, "does not exist");
  if (fs::is_directory(status)) {
    const bool slash = path.size() > 1 && path.ends_with('/');
    return read_out_folder(slash ? path.substr(0, path.size() - 1) : path);
  }
  RunInput run;
  run.name = path;
  run.groups.emplace_back();
  if (is_cloud_name(path)) {
    run.cloud = path;
    return run;
  }
  VehicleInput vehicle;
  vehicle.name = fs::path(path).stem().string();
  vehicle.file = path;
  Result<eval::PoseList> poses = read_poses(path, run.warnings, &vehicle.levelled);
  if (!poses) return tl::make_unexpected(poses.error());
  vehicle.trajectory.poses = std::move(*poses);
  run.vehicles.push_back(std::move(vehicle));
  run.groups.front().push_back(0);
  return run;
}

Status add_truth(const std::string& path, const geometry::SE3& T_body_truth, RunInput& run) {
  std::error_code error;
  if (!fs::exists(path, error)) return fail(ErrorCode::kInput, path, "does not exist");
  const bool folder = fs::is_directory(path, error);
  const std::vector<std::string> names = folder ? tum_names(path) : std::vector<std::string>{};
  const bool only_one = run.vehicles.size() == 1 && (!folder || names.size() == 1);
  if (!folder && run.vehicles.size() > 1) {
    return fail(ErrorCode::kInput, path,
                fmt::format("is one trajectory for {} vehicles", run.vehicles.size()),
                "Give a folder with one <vehicle>.tum each.");
  }
  std::size_t found = 0;
  for (VehicleInput& vehicle : run.vehicles) {
    vehicle.truth_file =
        folder ? path + '/' + (only_one ? names.front() : vehicle.name) + ".tum" : path;
    if (!exists(vehicle.truth_file)) {
      run.warnings.push_back(
          fmt::format("{}: no truth of {}; it is not judged", path, vehicle.name));
      vehicle.truth_file.clear();
      continue;
    }
    Result<eval::PoseList> poses = read_poses(vehicle.truth_file, run.warnings);
    if (!poses) return tl::make_unexpected(poses.error());
    vehicle.truth = std::move(*poses);
    carry_to_body(T_body_truth, vehicle.truth);
    ++found;
  }
  if (found == 0 && !run.vehicles.empty()) return no_truth(path, run, names);
  return {};
}

std::string mesh_beside_truth(const std::string& truth) {
  for (const char* name : {"/mesh.ply", "/mesh.obj", "/mesh.stl"}) {
    if (exists(truth + name)) return truth + name;
  }
  return {};
}

}  // namespace rali::assess
