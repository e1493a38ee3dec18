#pragma once

#include <cstdint>
#include <string>

#include "rali/base/result.hpp"
#include "rali/io/containers/byte_source.hpp"

namespace rali::io {

/// A temporary file (in TMPDIR), removed with this object. A reader that has opened it may outlive
/// it: the bytes are freed when the last reader closes.
class TempFile {
 public:
  [[nodiscard]] static Result<TempFile> create();

  TempFile(TempFile&& other) noexcept;
  TempFile& operator=(TempFile&& other) noexcept;
  TempFile(const TempFile&) = delete;
  TempFile& operator=(const TempFile&) = delete;
  ~TempFile();

  [[nodiscard]] const std::string& path() const { return path_; }

  [[nodiscard]] Status write(std::span<const std::byte> bytes);

 private:
  TempFile(int fd, std::string path) : fd_(fd), path_(std::move(path)) {}

  int fd_ = -1;
  std::string path_;
};

/// Result of decompressing a .zstd file.
struct Unpacked {
  TempFile file;
  std::string trouble;  ///< empty if complete: "is cut", "is damaged"
};

/// Decompresses a file to a temporary one, at most `bytes_max`. A truncated or damaged file gives
/// the part before the damage. Errors: disk full, no room for `bytes_max`.
[[nodiscard]] Result<Unpacked> unpack_zstd_file(ByteSource& source, std::uint64_t bytes_max);

}  // namespace rali::io
