#include "rali/drive/output/out_dir.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "rali/drive/version.hpp"
#include "rali/io/files/atomic_file.hpp"
#include "rali/io/files/input_file.hpp"
#include "rali/io/files/sha256.hpp"

namespace rali::drive {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 4> kExempt = {"run.log", "timing.json", "status.json",
                                                     "report.html"};
constexpr std::array<std::string_view, 19> kFixed = {
    "map.pcd",       "map.ply",         "map.las",     "removed.pcd",  "keyframes.csv",
    "graph.g2o",     "graph.pyfg",      "ranges.csv",  "rounds.csv",   "frontiers.csv",
    "loops.csv",     "map_2d.pgm",      "map_2d.yaml", "session.mcap", "metrics.json",
    "settings.yaml", "evaluation.json", "doctor.json", "report.json"};

/// One folder of outputs and the endings of its file names.
struct Folder {
  std::string_view name;
  std::array<std::string_view, 3> ends;
};

constexpr std::array<Folder, 5> kFolders = {{{"trajectory", {".tum", ".cov.csv", ".imu.tum"}},
                                             {"odometry", {".tum", ".cov.csv", ".cov.csv"}},
                                             {"live", {".tum", ".cov.csv", ".steps.csv"}},
                                             {"degeneracy", {".csv", ".csv", ".csv"}},
                                             {"errors", {".csv", ".csv", ".csv"}}}};

bool is_keyframe_file(std::string_view name) {
  if (!name.ends_with(".pcd") || name.size() < 5) return false;
  name.remove_suffix(4);
  return std::all_of(name.begin(), name.end(), [](char c) { return c >= '0' && c <= '9'; });
}

/// The name without the decoration of a temporary file: ".NAME.tmp".
std::string_view undressed(std::string_view name) {
  if (name.starts_with('.') && name.ends_with(".tmp") && name.size() > 5) {
    name.remove_prefix(1);
    name.remove_suffix(4);
  }
  return name;
}

Status machine_error(const std::string& path, const std::error_code& error) {
  return fail(ErrorCode::kMachine, path, error.message());
}

/// Removes folders that are empty after their outputs are gone, deepest first.
void remove_empty_folders(const fs::path& out) {
  std::error_code ignored;
  std::vector<fs::path> folders;
  for (const char* name : {"trajectory", "odometry", "live", "degeneracy", "errors", "keyframes"}) {
    folders.push_back(out / name);
  }
  fs::directory_iterator it(out / "keyframes", ignored);
  for (; !ignored && it != fs::directory_iterator(); it.increment(ignored)) {
    if (it->is_directory(ignored)) folders.push_back(it->path());
  }
  // fs::remove leaves a non-empty folder alone: files of others stay.
  for (auto f = folders.rbegin(); f != folders.rend(); ++f) fs::remove(*f, ignored);
}

bool is_made_by_rali(const fs::path& out) {
  std::ifstream file(out / "status.json");
  if (!file) return false;
  const nlohmann::json status = nlohmann::json::parse(file, nullptr, false);
  return status.is_object() && status.contains("rali") && status.contains("status");
}

/// The part of the path that exists and is no folder; empty if there is none.
std::string file_on_the_way(const std::string& path) {
  std::error_code error;
  for (fs::path part = path; !part.empty(); part = part.parent_path()) {
    const fs::file_status status = fs::status(part, error);
    if (fs::exists(status)) return fs::is_directory(status) ? std::string() : part.string();
    if (part == part.parent_path()) break;
  }
  return {};
}

/// A full disk has no space for a second file, but the block of the first one exists: a run that
/// ended must not keep the status "running".
void write_in_place(const std::string& file, const std::string& text) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return;
  std::fstream out(file, std::ios::in | std::ios::out | std::ios::binary);
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  out.flush();
  if (out) fs::resize_file(file, text.size(), error);
}

}  // namespace

bool is_exempt_name(std::string_view relative) {
  return std::find(kExempt.begin(), kExempt.end(), relative) != kExempt.end();
}

bool is_output_name(std::string_view relative) {
  const std::size_t slash = relative.rfind('/');
  const std::string_view name =
      undressed(slash == std::string_view::npos ? relative : relative.substr(slash + 1));
  if (slash == std::string_view::npos) {
    return is_exempt_name(name) || std::find(kFixed.begin(), kFixed.end(), name) != kFixed.end();
  }
  const std::string_view folder = relative.substr(0, slash);
  for (const Folder& f : kFolders) {
    if (folder != f.name) continue;
    return std::any_of(f.ends.begin(), f.ends.end(), [&](std::string_view end) {
      return name.size() > end.size() && name.ends_with(end);
    });
  }
  const bool keyframes =
      folder.starts_with("keyframes/") && folder.find('/', 10) == std::string_view::npos;
  return keyframes && is_keyframe_file(name);
}

Result<std::vector<std::string>> list_outputs(const std::string& path) {
  std::vector<std::string> names;
  std::error_code error;
  fs::recursive_directory_iterator it(path, error);
  for (; !error && it != fs::recursive_directory_iterator(); it.increment(error)) {
    if (!it->is_regular_file(error) || it->is_symlink(error)) continue;
    std::string name = it->path().lexically_relative(path).generic_string();
    if (is_output_name(name)) names.push_back(std::move(name));
  }
  if (error) return tl::make_unexpected(machine_error(path, error).error());
  std::sort(names.begin(), names.end());
  return names;
}

Status prepare_out_dir(const std::string& path, bool overwrite) {
  const std::string file = file_on_the_way(path);
  if (!file.empty()) {
    return fail(ErrorCode::kUsage, path,
                file == path ? "is a file, not a folder" : file + " is a file, not a folder",
                "Choose another with -o.");
  }
  std::error_code error;
  fs::create_directories(path, error);
  if (error) return machine_error(path, error);
  const bool empty = fs::is_empty(path, error);
  if (error) return machine_error(path, error);
  if (empty) return {};
  if (!overwrite) {
    return fail(ErrorCode::kUsage, "",
                fmt::format("{}{} is not empty", path, path.ends_with('/') ? "" : "/"),
                "Choose another or --overwrite (removes only what rali wrote).");
  }
  if (!is_made_by_rali(path)) {
    return fail(ErrorCode::kUsage, "",
                fmt::format("{} holds files but no status.json of rali", path),
                "Nothing was removed. Choose another folder.");
  }
  const Result<std::vector<std::string>> names = list_outputs(path);
  if (!names) return tl::make_unexpected(names.error());
  for (const std::string& name : *names) {
    fs::remove(fs::path(path) / name, error);
    if (error) return machine_error(path + '/' + name, error);
  }
  remove_empty_folders(path);
  return {};
}

Status write_status(const std::string& path, std::string_view status, bool hashes) {
  nlohmann::ordered_json json;
  json["schema"] = 1;
  json["rali"] = version();
  json["status"] = status;
  json["files"] = nlohmann::ordered_json::object();
  if (hashes) {
    const Result<std::vector<std::string>> names = list_outputs(path);
    if (!names) return tl::make_unexpected(names.error());
    for (const std::string& name : *names) {
      const std::size_t slash = name.rfind('/');
      const std::string last = slash == std::string::npos ? name : name.substr(slash + 1);
      if (is_exempt_name(name) || last.starts_with('.')) continue;
      const Result<std::string> sha = io::sha256_file(path + '/' + name);
      if (!sha) return tl::make_unexpected(sha.error());
      json["files"][name] = *sha;
    }
  }
  const std::string file = path + "/status.json";
  const Status written = io::write_file_atomic(file, json.dump(1) + '\n');
  if (written) return {};
  json["files"] = nlohmann::ordered_json::object();
  write_in_place(file, json.dump(1) + '\n');
  return written;
}

Status add_to_status(const std::string& path, const std::string& name,
                     std::string_view exempt_start, std::string_view exempt_end) {
  constexpr std::uint64_t kBytesMax = 256ULL << 20;
  const std::string file = path + "/status.json";
  if (!fs::exists(file)) return {};
  const auto status = io::read_file(file, kBytesMax);
  if (!status) return tl::make_unexpected(status.error());
  auto json = nlohmann::ordered_json::parse(io::as_text(*status), nullptr, false);
  if (!json.is_object() || !json["files"].is_object()) {
    return fail(ErrorCode::kInput, file, "is damaged", "Run rali map again.");
  }
  const auto bytes = io::read_file(path + '/' + name, kBytesMax);
  if (!bytes) return tl::make_unexpected(bytes.error());
  const std::string_view text = io::as_text(*bytes);
  const std::size_t begin = std::min(text.find(exempt_start), text.size());
  const std::size_t end = std::min(text.find(exempt_end, begin), text.size());
  const std::string hashed = std::string(text.substr(0, begin)) + std::string(text.substr(end));
  std::map<std::string, nlohmann::json> sorted;
  for (const auto& [key, value] : json["files"].items()) sorted[key] = value;
  sorted[name] = io::sha256_hex(io::text_bytes(hashed));
  json["files"] = nlohmann::ordered_json::object();
  for (const auto& [key, value] : sorted) json["files"][key] = value;
  return io::write_file_atomic(file, json.dump(1) + '\n');
}

}  // namespace rali::drive
