#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace rali::io {

enum class FileKind { kBag, kMcap, kSqlite, kZstd, kOther };

/// What a file is, by its first bytes.
struct KnownKind {
  FileKind kind = FileKind::kOther;
  std::string words;   ///< for kOther: "raw network packets (pcap), not decoded clouds"
  std::string remedy;  ///< for kOther: one sentence
};

/// Enough of a file's start for kind_of().
inline constexpr std::size_t kKindBytes = 512;

[[nodiscard]] KnownKind kind_of(std::span<const std::byte> start);

}  // namespace rali::io
