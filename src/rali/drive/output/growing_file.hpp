#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "rali/base/result.hpp"

namespace rali::drive {

/// A text file that grows during a run and stands under its own name from the start, so that a
/// kill leaves what was reached. Lines reach the disk whole and in groups: after every flush() the
/// file ends with a whole line.
class GrowingFile {
 public:
  GrowingFile() = default;
  ~GrowingFile();
  GrowingFile(const GrowingFile&) = delete;
  GrowingFile& operator=(const GrowingFile&) = delete;
  GrowingFile(GrowingFile&& other) noexcept;
  GrowingFile& operator=(GrowingFile&& other) noexcept;

  /// Makes the file and its folder. Errors: kMachine.
  [[nodiscard]] static Result<GrowingFile> create(const std::string& path);

  /// Adds text that ends with '\n'; kept in memory until flush() or 64 KiB.
  [[nodiscard]] Status add(std::string_view lines);

  /// Hands all lines to the operating system. Errors: kMachine (disk full); what was written
  /// before stays, cut back to whole lines.
  [[nodiscard]] Status flush();

  /// flush(), then waits for the disk and closes.
  [[nodiscard]] Status close();

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  int fd_ = -1;
  std::string path_;
  std::string waiting_;
  std::int64_t size_ = 0;
};

}  // namespace rali::drive
