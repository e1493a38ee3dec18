#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "rali/base/result.hpp"
#include "rali/factlog/record.hpp"

namespace rali::factlog {

/// An open file or directory, closed at the end of its life.
class File {
 public:
  enum class Mode {
    kFolder,     ///< a directory, for its lock and to sync the names in it
    kExisting,   ///< to read and write
    kRead,       ///< to read alone
    kCreate,     ///< likewise; made if it is not there
    kCreateNew,  ///< likewise; must not be there yet
  };

  /// Errors: kMachine.
  [[nodiscard]] static Result<File> open(const std::string& path, Mode mode);

  File(File&& other) noexcept;
  File& operator=(File&& other) noexcept;
  ~File();

  [[nodiscard]] Result<std::uint64_t> size() const;

  /// So many bytes from `offset` on; fewer only at the end of the file.
  [[nodiscard]] Result<Bytes> read(std::uint64_t offset, std::size_t bytes) const;

  enum class Written { kAll, kNoRoom };

  /// kNoRoom: the disk, a quota or a limit of the process allows no more; a part may be written.
  [[nodiscard]] Result<Written> write(std::uint64_t offset, std::span<const std::byte> bytes);

  [[nodiscard]] Status cut(std::uint64_t size);

  /// Data and size, or the names in a directory, are on the disk.
  [[nodiscard]] Status sync();

  /// False: another process, or another open file, has the lock.
  [[nodiscard]] Result<bool> lock();

  [[nodiscard]] const std::string& path() const { return path_; }

  [[nodiscard]] std::uint64_t free_bytes() const;

 private:
  File(int descriptor, std::string path, bool folder)
      : descriptor_(descriptor), path_(std::move(path)), folder_(folder) {}

  [[nodiscard]] tl::unexpected<Error> failed(const char* doing) const;

  int descriptor_ = -1;
  std::string path_;
  bool folder_ = false;
};

}  // namespace rali::factlog
