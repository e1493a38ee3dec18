#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rali/base/result.hpp"

namespace rali::io {

/// What happens to the unfinished `.NAME.tmp` when the object is destroyed without commit().
enum class OnAbandon {
  kRemove,  ///< an incomplete result is useless
  kKeep     ///< a stream whose lines so far are useful
};

/// A file that appears whole or not at all (product.md section 1): bytes go to `.NAME.tmp` in the
/// same folder; commit() flushes them to the disk and renames. An existing NAME stays untouched
/// until then. Errors are kMachine and name the path of the target.
class AtomicFile {
 public:
  [[nodiscard]] static Result<AtomicFile> create(const std::string& path,
                                                 OnAbandon on_abandon = OnAbandon::kRemove);

  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&& other) noexcept;
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  ~AtomicFile();

  [[nodiscard]] Status write(std::span<const std::byte> bytes);
  [[nodiscard]] Status write(std::string_view text);

  /// Replaces bytes that were written before; for headers with values known only later.
  [[nodiscard]] Status overwrite(std::uint64_t offset, std::span<const std::byte> bytes);

  /// Flushes everything written so far to the disk (fdatasync of the temporary file). It then
  /// survives a kill and a power loss, under its temporary name.
  [[nodiscard]] Status sync();

  /// After a failed write (full disk): renames the file with its whole lines to NAME, which needs
  /// no space. Without any line, or if that fails too, the temporary file is removed.
  void keep_whole_lines();

  /// Flushes, syncs, renames, syncs the folder. Nothing may be written afterwards. Fails if an
  /// earlier write failed, since bytes are missing then.
  [[nodiscard]] Status commit();

  [[nodiscard]] std::uint64_t size() const { return written_ + buffer_.size(); }

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  AtomicFile(std::string path, std::string temporary, int fd, OnAbandon on_abandon);

  void abandon() noexcept;
  [[nodiscard]] Status flush();
  [[nodiscard]] Status write_out(std::span<const std::byte> bytes);
  [[nodiscard]] tl::unexpected<Error> failure(std::string_view doing, int error_number) const;
  [[nodiscard]] tl::unexpected<Error> broken(int error_number);

  std::string path_;
  std::string temporary_;
  int fd_ = -1;
  OnAbandon on_abandon_ = OnAbandon::kRemove;
  std::vector<std::byte> buffer_;
  std::uint64_t written_ = 0;
  std::optional<Error> broken_;  ///< the first failed write: later bytes would be torn
};

/// create, write, commit.
[[nodiscard]] Status write_file_atomic(const std::string& path, std::span<const std::byte> bytes);
[[nodiscard]] Status write_file_atomic(const std::string& path, std::string_view text);

/// `.NAME.tmp` beside `path`.
[[nodiscard]] std::string temporary_path_of(const std::string& path);

}  // namespace rali::io
