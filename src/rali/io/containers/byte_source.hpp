#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rali/base/result.hpp"

namespace rali::io {

/// The bytes of a recording at any offset: a file, or memory in tests and fuzzing.
class ByteSource {
 public:
  virtual ~ByteSource() = default;

  [[nodiscard]] virtual std::uint64_t size() const = 0;

  /// Name given by the user; every error message starts with it.
  [[nodiscard]] virtual const std::string& name() const = 0;

  /// Fills `out` from `offset`. The caller keeps within size(). An Error means a failure of the
  /// disk, or that the file shrank while being read.
  [[nodiscard]] virtual Status read(std::uint64_t offset, std::span<std::byte> out) = 0;

  /// The first offset at or behind this one that is not in a hole of a sparse file (a hole reads as
  /// zeros); size() if nothing follows.
  [[nodiscard]] virtual std::uint64_t next_data(std::uint64_t offset) { return offset; }
};

/// Opens a regular file for reading; needs no write permission. `name` is used in messages, the
/// path if empty.
[[nodiscard]] Result<std::shared_ptr<ByteSource>> open_file_bytes(const std::string& path,
                                                                  std::string name = {});

[[nodiscard]] std::shared_ptr<ByteSource> memory_bytes(std::vector<std::byte> bytes,
                                                       std::string name);

/// True if the source starts with this text.
[[nodiscard]] Result<bool> starts_with(ByteSource& source, std::string_view text);

/// Small reads without a system call each. One view at a time.
class ByteWindow {
 public:
  explicit ByteWindow(std::shared_ptr<ByteSource> source) : source_(std::move(source)) {}

  /// `n` bytes at `offset`, fewer where the source ends. Valid until the next call. Memory grows
  /// to `n`, so the caller checks `n` against its own limit first.
  [[nodiscard]] Result<std::span<const std::byte>> view(std::uint64_t offset, std::size_t n);

 private:
  std::shared_ptr<ByteSource> source_;
  std::vector<std::byte> buffer_;
  std::uint64_t begin_ = 0;
  std::size_t filled_ = 0;
};

}  // namespace rali::io
