#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "rali/base/result.hpp"

namespace rali::io {

/// A regular file open for reading. Errors name the path.
class InputFile {
 public:
  /// Errors: kInput (missing, a folder, no permission).
  [[nodiscard]] static Result<InputFile> open(const std::string& path);

  InputFile(InputFile&& other) noexcept;
  InputFile& operator=(InputFile&& other) noexcept;
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  ~InputFile();

  /// Fills as much of `buffer` as the file still has; 0 at the end. Errors: kMachine.
  [[nodiscard]] Result<std::size_t> read(std::span<std::byte> buffer);

  /// Size when it was opened [bytes].
  [[nodiscard]] std::uint64_t size() const { return size_; }

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  InputFile(std::string path, int fd, std::uint64_t size);

  std::string path_;
  int fd_ = -1;
  std::uint64_t size_ = 0;
};

/// The whole content. Errors: kInput if it cannot be opened or is larger than `max_bytes`.
[[nodiscard]] Result<std::vector<std::byte>> read_file(const std::string& path,
                                                       std::uint64_t max_bytes);

/// Bytes viewed as text; no copy.
[[nodiscard]] inline std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Text viewed as bytes; no copy.
[[nodiscard]] inline std::span<const std::byte> text_bytes(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

}  // namespace rali::io
