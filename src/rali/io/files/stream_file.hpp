#pragma once

#include <string>
#include <string_view>

#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/io/files/atomic_file.hpp"

namespace rali::io {

/// A file that grows with the data: lines go to `.NAME.tmp`, which is flushed to the disk
/// (fdatasync) every 10 s of data and is renamed to NAME by finish(). A kill or power loss
/// therefore costs at most 10 s of data. The whole lines remain in `.NAME.tmp`, as they do when the
/// object is destroyed without finish().
class StreamFile {
 public:
  [[nodiscard]] static Result<StreamFile> create(const std::string& path);

  /// Appends text that belongs to data time t.
  [[nodiscard]] Status add(std::string_view text, Time t);

  /// Appends text without a time (a header, a row without a stamp).
  [[nodiscard]] Status add(std::string_view text);

  /// If the disk is full, the file with its whole lines is renamed to NAME; the error is returned.
  [[nodiscard]] Status finish();

  [[nodiscard]] const std::string& path() const { return file_.path(); }

 private:
  explicit StreamFile(AtomicFile file) : file_(std::move(file)) {}

  AtomicFile file_;
  Time synced_;
  bool has_time_ = false;
};

}  // namespace rali::io
