#pragma once

#include <string>
#include <string_view>

#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/io/files/atomic_file.hpp"

namespace rali::io {

/// A file that grows with the data: lines go to `.NAME.tmp`, which is brought to the disk
/// (fdatasync) whenever 10 s of data have passed, and becomes NAME at finish(). A kill or power
/// loss therefore costs at most 10 s of data: what is whole stands in `.NAME.tmp`, as it does when
/// the object goes away without finish().
class StreamFile {
 public:
  [[nodiscard]] static Result<StreamFile> create(const std::string& path);

  /// Appends text that belongs to data time t.
  [[nodiscard]] Status add(std::string_view text, Time t);

  /// Appends text without a time (a header, a row about no moment).
  [[nodiscard]] Status add(std::string_view text);

  /// Where the disk is full, the whole lines that reached it get the name; the error is returned.
  [[nodiscard]] Status finish();

  [[nodiscard]] const std::string& path() const { return file_.path(); }

 private:
  explicit StreamFile(AtomicFile file) : file_(std::move(file)) {}

  AtomicFile file_;
  Time synced_;
  bool has_time_ = false;
};

}  // namespace rali::io
