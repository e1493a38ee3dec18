#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "rali/io/containers/bag_reader.hpp"
#include "rali/io/containers/byte_source.hpp"
#include "rali/io/containers/db3_reader.hpp"
#include "rali/io/containers/file_kind.hpp"
#include "rali/io/containers/mcap_reader.hpp"
#include "rali/io/containers/rosbag2_folder.hpp"
#include "rali/io/containers/split_source.hpp"
#include "rali/io/containers/temp_file.hpp"
#include "rali/io/input_kind.hpp"
#include "rali/io/message_source.hpp"

namespace rali::io {
namespace {

namespace fs = std::filesystem;

using Opened = Result<std::unique_ptr<MessageSource>>;

Result<KnownKind> kind_of_file(ByteSource& source) {
  std::vector<std::byte> start(std::min<std::uint64_t>(kKindBytes, source.size()));
  if (const Status status = source.read(0, start); !status) {
    return tl::make_unexpected(status.error());
  }
  return kind_of(start);
}

Opened open_sqlite(const std::string& path, const std::string& name, std::uint64_t bytes,
                   const Db3Hints& hints, const ReadLimits& limits) {
  auto database = SqlDatabase::open_file(path, limits.chunk_bytes);
  if (!database) return tl::make_unexpected(database.error());
  return open_db3(std::move(*database), name, bytes, hints, limits);
}

/// A file that is not compressed as a whole. `name` is the user's name for it.
Opened open_plain(const std::string& path, const std::string& name, const Db3Hints& hints,
                  const ReadLimits& limits) {
  auto source = open_file_bytes(path, name);
  if (!source) return tl::make_unexpected(source.error());
  const auto kind = kind_of_file(**source);
  if (!kind) return tl::make_unexpected(kind.error());
  if (kind->kind == FileKind::kBag) return open_bag(std::move(*source), limits);
  if (kind->kind == FileKind::kMcap) return open_mcap(std::move(*source), limits);
  if (kind->kind == FileKind::kSqlite) {
    return open_sqlite(path, name, (*source)->size(), hints, limits);
  }
  return fail(ErrorCode::kInput, name, kind->words, kind->remedy);
}

/// A file compressed as a whole; decompressed to a temporary file.
Opened open_zstd(ByteSource& source, const Db3Hints& hints, const ReadLimits& limits) {
  const std::string& name = source.name();
  auto unpacked = unpack_zstd_file(source, limits.temp_bytes);
  if (!unpacked) return tl::make_unexpected(unpacked.error());
  auto inside = open_plain(unpacked->file.path(), name, hints, limits);
  if (!inside) {
    Error error = inside.error();
    error.where = name;
    if (!unpacked->trouble.empty())
      error.what += " (the compressed file " + unpacked->trouble + ")";
    return tl::make_unexpected(error);
  }
  if (unpacked->trouble.empty()) return inside;
  // Shared, because a std::function must be copyable. It is called once.
  auto held = std::make_shared<std::unique_ptr<MessageSource>>(std::move(*inside));
  auto all = std::make_unique<SplitSource>(
      name, std::vector<SplitSource::Part>{{name, source.size(), true}},
      [held](const std::string&) -> Opened { return std::move(*held); }, limits);
  all->note(Severity::kWarning,
            "compressed file " + unpacked->trouble + "; what lies before is read");
  all->set_truncated();
  if (const Status status = all->start(); !status) return tl::make_unexpected(status.error());
  return all;
}

Opened open_one(const std::string& path, const Db3Hints& hints, const ReadLimits& limits) {
  auto source = open_file_bytes(path);
  if (!source) return tl::make_unexpected(source.error());
  const auto kind = kind_of_file(**source);
  if (!kind) return tl::make_unexpected(kind.error());
  if (kind->kind == FileKind::kZstd) return open_zstd(**source, hints, limits);
  return open_plain(path, path, hints, limits);
}

bool is_zstd_file(const std::string& path) {
  const auto source = open_file_bytes(path);
  if (!source) return false;
  const auto kind = kind_of_file(**source);
  return kind && kind->kind == FileKind::kZstd;
}

Opened open_folder(const std::string& folder) {
  const ReadLimits limits;
  const auto list = list_rosbag2_folder(folder);
  if (!list) return tl::make_unexpected(list.error());
  const Db3Hints hints{list->zstd_messages};
  std::vector<SplitSource::Part> parts;
  for (const std::string& path : list->paths) {
    std::error_code error;
    const auto bytes = fs::file_size(path, error);
    parts.push_back({path, error ? 0 : bytes, !is_zstd_file(path)});
  }
  auto all = std::make_unique<SplitSource>(
      folder, std::move(parts),
      [hints, limits](const std::string& path) { return open_one(path, hints, limits); }, limits);
  for (const Rosbag2Folder::Note& note : list->notes) all->note(note.severity, note.text);
  if (const Status status = all->start(); !status) return tl::make_unexpected(status.error());
  return all;
}

}  // namespace

Result<std::unique_ptr<MessageSource>> open_recording(const std::string& path) {
  if (const auto kind = input_kind(path); !kind) return tl::make_unexpected(kind.error());
  std::error_code error;
  if (fs::is_directory(path, error)) return open_folder(path);
  return open_one(path, {}, {});
}

}  // namespace rali::io
