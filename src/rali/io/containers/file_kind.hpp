#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace rali::io {

enum class FileKind { kBag, kMcap, kSqlite, kZstd, kOther };

/// Kind of a file by its first bytes.
struct KnownKind {
  FileKind kind = FileKind::kOther;
  std::string words;   ///< for kOther: "raw network packets (pcap), not decoded clouds"
  std::string remedy;  ///< for kOther: one sentence
};

/// Number of bytes from the start of a file that kind_of() needs.
inline constexpr std::size_t kKindBytes = 512;

[[nodiscard]] KnownKind kind_of(std::span<const std::byte> start);

}  // namespace rali::io
