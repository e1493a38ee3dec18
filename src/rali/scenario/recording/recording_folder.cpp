#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <string_view>

#include "rali/scenario/recording/write_recording.hpp"

namespace rali::scenario {
namespace {

namespace fs = std::filesystem;

bool is_vehicle(std::string_view name) {
  return name.size() >= 2 && name.size() <= 3 && name[0] == 'v' &&
         std::all_of(name.begin() + 1, name.end(),
                     [](unsigned char c) { return std::isdigit(c) != 0; });
}

/// NAME of a file that is being written as ".NAME.tmp"; other names unchanged.
std::string_view undressed(std::string_view name) {
  if (name.size() > 5 && name.starts_with('.') && name.ends_with(".tmp")) {
    name.remove_prefix(1);
    name.remove_suffix(4);
  }
  return name;
}

bool is_ours(const fs::path& folder, std::string_view relative_folder, std::string_view name) {
  constexpr std::array<std::string_view, 9> kTop = {
      "ranges.csv", "radio.csv",     "fleet.yaml", "scene.yaml", "simulation.json",
      "rounds.csv", "frontiers.csv", "live.yaml",  "fleet.key"};
  constexpr std::array<std::string_view, 3> kTruth = {"ranges.csv", "biases.csv", "mesh.ply"};
  const bool dressed = undressed(name).size() != name.size();
  name = undressed(name);
  const std::size_t dot = name.find('.');
  const std::string_view stem = name.substr(0, dot);
  const std::string_view end = dot == std::string_view::npos ? "" : name.substr(dot);
  if (relative_folder.empty()) {
    if (std::find(kTop.begin(), kTop.end(), name) != kTop.end()) return true;
    if (!is_vehicle(stem)) return false;
    if (dressed) return true;
    return end == ".mcap" || end == ".bag" ||
           (end.empty() && fs::exists(folder / std::string(name) / "metadata.yaml"));
  }
  return std::find(kTruth.begin(), kTruth.end(), name) != kTruth.end() ||
         (is_vehicle(stem) && end == ".tum");
}

/// Removes a rosbag2 folder written by this program: its database and metadata, nothing else.
void remove_rosbag2(const fs::path& folder, std::error_code& error) {
  const std::string name = folder.filename().string();
  fs::remove(folder / (name + "_0.db3"), error);
  if (!error) fs::remove(folder / "metadata.yaml", error);
  std::error_code ignored;
  fs::remove(folder, ignored);  // stays if it has other files
}

void remove_in(const fs::path& root, std::string_view relative, std::error_code& error) {
  std::vector<fs::path> found;
  const fs::path folder = relative.empty() ? root : root / std::string(relative);
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (is_ours(root, relative, it->path().filename().string())) found.push_back(it->path());
  }
  if (error) return;
  std::sort(found.begin(), found.end());
  // The mark is removed last: after a failed removal the rest can still be removed.
  std::stable_partition(found.begin(), found.end(),
                        [](const fs::path& p) { return p.filename() != "simulation.json"; });
  for (const fs::path& path : found) {
    if (fs::is_directory(path, error)) {
      // A folder with a temporary name was written by this program, with all its contents.
      if (path.filename().string().front() == '.') {
        fs::remove_all(path, error);
      } else {
        remove_rosbag2(path, error);
      }
    } else if (!error) {
      fs::remove(path, error);
    }
    if (error) return;
  }
}

}  // namespace

Status prepare_recording_folder(const std::string& folder, bool overwrite) {
  std::error_code error;
  const auto machine = [&] { return fail(ErrorCode::kMachine, folder, error.message()); };
  fs::create_directories(folder, error);
  if (error) return machine();
  const bool empty = fs::is_empty(folder, error);
  if (error) return machine();
  if (!empty && !overwrite) {
    return fail(ErrorCode::kUsage, folder, "is not empty",
                "Choose another or --overwrite (removes only what rali simulate wrote).");
  }
  if (!empty) {
    if (!fs::exists(fs::path(folder) / "simulation.json", error)) {
      return fail(ErrorCode::kUsage, folder, "was not made by rali simulate, so nothing is removed",
                  "Choose another folder.");
    }
    if (fs::exists(fs::path(folder) / "truth", error)) remove_in(folder, "truth", error);
    if (!error) remove_in(folder, "", error);
    if (error) return machine();
  }
  fs::create_directories(folder + "/truth", error);
  if (error) return machine();
  return {};
}

}  // namespace rali::scenario
