#include "rali/io/containers/rosbag2_folder.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "rali/io/files/text.hpp"

namespace rali::io {
namespace {

namespace fs = std::filesystem;

// Real files have some kilobytes, or some hundred with a thousand splits.
constexpr std::size_t kMetadataBytesMax = 16U << 20;

std::string unquoted(std::string_view text) {
  text = trimmed(text);
  if (text.size() >= 2 && (text.front() == '"' || text.front() == '\'') &&
      text.back() == text.front()) {
    text = text.substr(1, text.size() - 2);
  }
  return std::string(text);
}

/// The value of `key:` on this line, if it is this key.
std::optional<std::string_view> value_of(std::string_view line, std::string_view key) {
  if (!line.starts_with(key) || line.size() <= key.size() || line[key.size()] != ':') {
    return std::nullopt;
  }
  return trimmed(line.substr(key.size() + 1));
}

/// "[a, b]" on one line.
void add_flow_list(std::string_view list, std::vector<std::string>& out) {
  if (!list.starts_with('[')) return;
  list = list.substr(1, list.find(']') - 1);
  while (!list.empty()) {
    const std::size_t comma = list.find(',');
    std::string item = unquoted(list.substr(0, comma));
    if (!item.empty()) out.push_back(std::move(item));
    list = comma == std::string_view::npos ? std::string_view() : list.substr(comma + 1);
  }
}

/// Without ".zstd" and the extension, so that "x_0.db3" and "x_0.db3.zstd" are one.
std::string stem_of(const std::string& name) {
  fs::path path(name);
  if (path.extension() == ".zstd" || path.extension() == ".zst") path = path.stem();
  return path.stem().string();
}

/// The name without the number of the split: "run_12" gives "run".
std::string family_of(const std::string& name) {
  const std::string stem = stem_of(name);
  const std::size_t end = stem.find_last_not_of("0123456789");
  if (end == std::string::npos || end + 1 == stem.size() || stem[end] != '_') return stem;
  return stem.substr(0, end);
}

bool is_recording_name(const std::string& name) {
  fs::path path(name);
  if (path.extension() == ".zstd" || path.extension() == ".zst") path = path.stem();
  return path.extension() == ".db3" || path.extension() == ".mcap";
}

struct Listing {
  std::vector<std::string> recordings;  ///< names in natural order, one per stem
  std::size_t ros1_bags = 0;
};

Result<Listing> list(const std::string& folder) {
  Listing out;
  std::error_code error;
  std::vector<std::string> names;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (is_recording_name(name)) names.push_back(name);
    if (entry->path().extension() == ".bag") ++out.ros1_bags;
  }
  if (error) return fail(ErrorCode::kMachine, folder, "cannot be listed: " + error.message());
  std::sort(names.begin(), names.end(), natural_less);
  std::set<std::string> stems;
  for (std::string& name : names) {
    // ".db3" sorts before ".db3.zstd": the decompressed file takes precedence.
    if (stems.insert(stem_of(name)).second) out.recordings.push_back(std::move(name));
  }
  return out;
}

std::optional<Rosbag2Metadata> read_metadata(const std::string& folder) {
  std::ifstream file(fs::path(folder) / "metadata.yaml", std::ios::binary);
  if (!file) return std::nullopt;
  std::string text(kMetadataBytesMax, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  return parse_rosbag2_metadata(text);
}

/// Existing files of the metadata, matched by name alone. Older versions list "folder/file", newer
/// ones "file", folders get renamed, and ".zstd" may be missing or left over.
void take_listed(const std::string& folder, const Rosbag2Metadata& metadata,
                 const std::vector<std::string>& present, Rosbag2Folder& out) {
  for (const std::string& listed : metadata.files) {
    const std::string stem = stem_of(fs::path(listed).filename().string());
    const auto found = std::find_if(present.begin(), present.end(),
                                    [&](const std::string& name) { return stem_of(name) == stem; });
    if (found == present.end()) {
      out.notes.push_back(
          {Severity::kWarning, fmt::format("metadata.yaml lists {}, which is not there", listed)});
    } else {
      out.paths.push_back((fs::path(folder) / *found).string());
    }
  }
}

}  // namespace

Rosbag2Metadata parse_rosbag2_metadata(std::string_view yaml) {
  Rosbag2Metadata out;
  bool in_files = false;
  while (!yaml.empty()) {
    const std::size_t end = yaml.find('\n');
    const std::string_view line = trimmed(yaml.substr(0, end));
    yaml = end == std::string_view::npos ? std::string_view() : yaml.substr(end + 1);
    if (in_files && line.starts_with("- ")) {
      out.files.push_back(unquoted(line.substr(2)));
      continue;
    }
    if (!line.empty() && !line.starts_with('#')) in_files = false;
    if (const auto files = value_of(line, "relative_file_paths")) {
      in_files = true;
      add_flow_list(*files, out.files);
    }
    if (const auto mode = value_of(line, "compression_mode"))
      out.compression_mode = unquoted(*mode);
  }
  return out;
}

Result<Rosbag2Folder> list_rosbag2_folder(const std::string& folder) {
  const auto present = list(folder);
  if (!present) return tl::make_unexpected(present.error());
  const std::vector<std::string>& names = present->recordings;
  if (names.empty()) {
    if (present->ros1_bags == 0) {
      return fail(ErrorCode::kInput, folder, "directory without recordings",
                  "Name a ROS 1 .bag, an MCAP or a rosbag2 folder.");
    }
    return fail(ErrorCode::kInput, folder,
                fmt::format("directory of {} ROS 1 bags", present->ros1_bags),
                "Name one of its files.");
  }
  Rosbag2Folder out;
  const auto metadata = read_metadata(folder);
  if (metadata) {
    out.zstd_messages =
        metadata->compression_mode == "MESSAGE" || metadata->compression_mode == "message";
    take_listed(folder, *metadata, names, out);
    if (!out.paths.empty()) return out;
    out.notes.push_back({Severity::kWarning,
                         "metadata.yaml lists no file that is there; files taken by their names"});
  } else {
    out.notes.push_back({Severity::kInfo, "no metadata.yaml; files taken by their names"});
  }
  for (const std::string& name : names) {
    if (family_of(name) != family_of(names.front())) {
      return fail(ErrorCode::kInput, folder,
                  fmt::format("directory of several recordings ({}, {}, ...) without metadata.yaml",
                              names.front(), name),
                  "Name one of its files.");
    }
    out.paths.push_back((fs::path(folder) / name).string());
  }
  return out;
}

}  // namespace rali::io
