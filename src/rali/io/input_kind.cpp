#include "rali/io/input_kind.hpp"

#include <array>
#include <cerrno>
#include <filesystem>
#include <string_view>
#include <system_error>

#include <fmt/format.h>
#include <sys/stat.h>

#include "rali/base/counted.hpp"
#include "rali/io/files/system_error.hpp"
#include "rali/io/files/text.hpp"

namespace rali::io {
namespace {

namespace fs = std::filesystem;

bool is_cloud_name(const fs::path& path) {
  const std::string extension = lower_case(path.extension().string());
  return extension == ".pcd" || extension == ".ply" || extension == ".bin";
}

bool is_recording_name(const std::string& name) {
  constexpr std::array<std::string_view, 4> kEndings = {".bag", ".mcap", ".db3", ".db3.zstd"};
  for (const std::string_view ending : kEndings) {
    if (name.ends_with(ending)) return true;
  }
  return false;
}

struct Contents {
  std::size_t clouds = 0, recordings = 0;
  bool metadata = false;
  bool state = false;  ///< state of a live vehicle, module factlog
};

Result<Contents> contents_of(const std::string& folder) {
  Contents found;
  std::error_code error;
  fs::directory_iterator at(folder, error);
  for (; !error && at != fs::directory_iterator(); at.increment(error)) {
    const std::string name = at->path().filename().string();
    std::error_code ignored;
    if (name.starts_with('.') || at->is_directory(ignored)) continue;
    if (name == "metadata.yaml") found.metadata = true;
    if (name == "role.slots") found.state = true;
    if (is_cloud_name(name)) ++found.clouds;
    if (is_recording_name(lower_case(name))) ++found.recordings;
  }
  if (error) {
    return fail(input_error_code(error.value()), folder,
                "cannot be listed: " + system_error_text(error.value()));
  }
  return found;
}

Result<InputKind> kind_of_folder(const std::string& path) {
  const Result<Contents> found = contents_of(path);
  if (!found) return tl::make_unexpected(found.error());
  if (found->metadata) return InputKind::kRecording;
  if (found->clouds > 0 && found->recordings > 0) {
    return fail(
        ErrorCode::kInput, path,
        fmt::format("holds {} and {}; which is meant is not known", counted(found->clouds, "cloud"),
                    counted(found->recordings, "recording")),
        "Keep one kind in the folder, or name the recording.");
  }
  if (found->clouds > 0) return InputKind::kScanFolder;
  if (found->recordings > 0) return InputKind::kRecording;
  if (found->state) {
    return fail(ErrorCode::kInput, path, "is the state folder of a live vehicle, not a recording",
                "Make a map of it first: rali map " + path);
  }
  return fail(ErrorCode::kInput, path,
              "holds neither a recording (*.bag, *.mcap, *.db3) nor scans (*.pcd, *.ply, *.bin)");
}

}  // namespace

Result<InputKind> input_kind(const std::string& path) {
  struct stat info = {};
  if (::stat(path.c_str(), &info) != 0) {
    const int reason = errno;
    if (reason == ENOENT) return fail(ErrorCode::kInput, path, "there is no such file or folder");
    return fail(input_error_code(reason), path, "cannot be opened: " + system_error_text(reason));
  }
  if (S_ISDIR(info.st_mode)) return kind_of_folder(path);
  return is_cloud_name(path) ? InputKind::kCloud : InputKind::kRecording;
}

}  // namespace rali::io
